"""Queries to the gates of real robots. Robots are asked all at once, and each answer is a GateStatus or an error."""

import asyncio
from collections.abc import Callable, Sequence

from fes.errors import FesError, MessageError, Rejected, Unavailable
from fes.protocol import keys
from fes.protocol.robot_control import STOPPED, GateStatus, Start, decode_gate_status, encode_start
from fes.transport.bus import Bus

PATIENCE = 1.0
"""Longest wait for one answer [s]."""

PAUSE = 0.1
"""Time between two queries of a gate that has not confirmed its stop [s]."""

STOPPING = 10.0
"""Longest time in which a stop is repeated [s]."""

Answer = GateStatus | FesError
Answers = dict[int, Answer]
"""Robot -> what its gate answered, ascending."""

Key = Callable[[str, int | str], str]
"""A function of `fes.protocol.keys` for a key of queries."""


async def present(bus: Bus, run: str) -> list[int]:
    """The robots whose gates are alive, ascending; raises Unavailable if there is none."""
    tokens = await bus.liveliness_get(keys.gate_alive(run, "*"), PATIENCE)
    robots = sorted({robot for key in tokens if (robot := keys.robot_of(key)) is not None})
    if not robots:
        raise Unavailable(f"no gate of run '{run}' is alive")
    return robots


async def ask(bus: Bus, key: Key, run: str, robots: Sequence[int], timeout: float = PATIENCE) -> Answers:
    """The answer of each gate to one query, within `timeout` [s]."""
    answers = await asyncio.gather(*(_ask(bus, key(run, robot), robot, timeout) for robot in robots))
    return dict(zip(robots, answers, strict=True))


async def start(bus: Bus, run: str, robots: Sequence[int], timeout: float = PATIENCE) -> Answers:
    """The answer of each gate to one start. A gate takes only a start that quotes a recent reading of its clock."""

    async def start_one(robot: int) -> Answer:
        state = await _ask(bus, keys.gate_status(run, robot), robot, timeout)
        if not isinstance(state, GateStatus):
            return state
        return await _ask(bus, keys.gate_start(run, robot), robot, timeout, encode_start(Start(state.clock)))

    return dict(zip(robots, await asyncio.gather(*map(start_one, robots)), strict=True))


async def stop(bus: Bus, run: str, robots: Sequence[int], timeout: float = STOPPING) -> Answers:
    """The last answer of each gate to a stop, repeated until each has confirmed it or `timeout` [s] is over."""
    answers: Answers = {}
    end = asyncio.get_running_loop().time() + timeout

    async def repeat(robot: int) -> None:
        while True:
            answers.update(await ask(bus, keys.gate_stop, run, [robot]))
            if is_stopped(answers[robot]) or asyncio.get_running_loop().time() >= end:
                return
            await asyncio.sleep(PAUSE)

    await asyncio.gather(*map(repeat, robots))
    return dict(sorted(answers.items()))


def is_stopped(answer: Answer) -> bool:
    """True if a gate confirms that its robot is stopped until it is started."""
    return isinstance(answer, GateStatus) and answer.mode == STOPPED


def is_started(answer: Answer) -> bool:
    """True if a gate lets its robot move, now or as soon as its own conditions hold."""
    return isinstance(answer, GateStatus) and answer.mode != STOPPED


def words(answer: Answer) -> str:
    """An answer in words, such as 'stopped, fence'."""
    if isinstance(answer, GateStatus):
        return f"{answer.mode}, {answer.reason}" if answer.reason else answer.mode
    if isinstance(answer, Unavailable):
        return "its gate does not answer"
    return str(answer)


async def _ask(bus: Bus, key: str, robot: int, timeout: float, payload: bytes = b"") -> Answer:
    try:
        status = decode_gate_status(await bus.get(key, payload, timeout))
    except (MessageError, Rejected, Unavailable) as error:
        return error
    if status.robot != robot:
        return Rejected(f"its gate answers for robot {status.robot}")
    return status
