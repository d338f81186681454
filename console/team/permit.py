"""The operator's permission to move, and a team that moves as long as it is held."""

import asyncio
import contextlib
import math
import secrets
import time
from collections.abc import AsyncIterator, Callable, Sequence

from console.doctor.network import spans
from console.team import gates
from console.team.gates import Answer, Answers
from fes.errors import Unavailable
from fes.protocol import keys
from fes.protocol.robot_control import MAX_OPERATOR, Permit, encode_permit
from fes.transport.bus import Bus

PERIOD = 0.2
"""Time between two Permits [s]."""

CLOCK = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)
"""Clock of the Permits: on Linux it also runs while the machine sleeps."""

BEFORE = 3 * PERIOD
"""Time for which Permits are published before the first start [s]: the gates must have heard one."""

WATCH = 1.0
"""Time between two looks at the gates while a permit is held [s]."""

Say = Callable[[str], None]
"""Shows one line to a person."""


async def publish(bus: Bus, run: str, seconds: float = math.inf) -> None:
    """Publish a Permit each PERIOD, for `seconds`. After a pause of this process no Permit is made up for."""
    loop = asyncio.get_running_loop()
    # An operator who waits for a congested network could not stop: a Permit is dropped rather than queued.
    put = bus.declare_publisher(keys.permit(run), "Permit", drop=True)
    operator, sequence = secrets.randbelow(MAX_OPERATOR), 0
    due = loop.time()
    end = due + seconds
    while due < end:
        put(encode_permit(Permit(operator, sequence, time.clock_gettime_ns(CLOCK))))
        sequence += 1
        due = max(due + PERIOD, loop.time())
        await asyncio.sleep(min(due, end) - loop.time())


@contextlib.asynccontextmanager
async def held(bus: Bus, run: str) -> AsyncIterator["asyncio.Task[None]"]:
    """A block during which Permits are published, by a task; no Permit follows its end."""
    task = asyncio.create_task(publish(bus, run), name="permit")
    try:
        await asyncio.sleep(BEFORE)
        yield task
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def start(bus: Bus, run: str, robots: Sequence[int], say: Say) -> list[int]:
    """Ask each gate once to start; returns the robots that do.

    A start is never repeated: it could undo the stop of another operator.
    """
    answers = await gates.start(bus, run, robots)
    for robot, answer in answers.items():
        if not gates.is_started(answer):
            say(f"robot {robot} did not start: {gates.words(answer)}")
    started = [robot for robot, answer in answers.items() if gates.is_started(answer)]
    if started:
        say(f"started: {spans(started)}")
    silent = [robot for robot, answer in answers.items() if isinstance(answer, Unavailable)]
    if silent:  # a start that is still on its way must not move a robot later: the stop comes after it
        await gates.stop(bus, run, silent, gates.PATIENCE)
    return started


async def stop(bus: Bus, run: str, robots: Sequence[int], say: Say, timeout: float = gates.STOPPING) -> bool:
    """Stop each robot, and name those whose gate does not confirm it; True if all do."""
    answers = await gates.stop(bus, run, robots, timeout)
    stopped = [robot for robot, answer in answers.items() if gates.is_stopped(answer)]
    if stopped:
        say(f"stopped: {spans(stopped)}")
    for robot, answer in answers.items():
        if not gates.is_stopped(answer):
            say(f"robot {robot} has NOT confirmed its stop: {gates.words(answer)}")
    return len(stopped) == len(robots)


async def start_and_hold(bus: Bus, run: str, robots: Sequence[int], say: Say) -> bool:
    """Start the robots, renew their permit until this task is cancelled, and stop them.

    True if each robot started and confirmed its stop. The robots are stopped after any error too.
    """
    is_complete = False
    try:
        async with held(bus, run) as permits:
            started = await start(bus, run, robots, say)
            is_complete = len(started) == len(robots)
            if not started:
                return False
            say("the permit is renewed until Ctrl-C, which stops the robots")
            watching = asyncio.create_task(watch(bus, run, robots, say), name="watch")
            try:
                done, _ = await asyncio.wait([permits, watching], return_when=asyncio.FIRST_COMPLETED)
            finally:
                watching.cancel()
                await asyncio.gather(watching, return_exceptions=True)
            await done.pop()  # raises the error that ended it
    except asyncio.CancelledError:
        task = asyncio.current_task()
        if task is not None:
            task.uncancel()
    finally:
        is_stopped = await stop(bus, run, robots, say)
    return is_complete and is_stopped


async def watch(bus: Bus, run: str, robots: Sequence[int], say: Say) -> None:
    """Show each change of a gate's mode, reason or silence, until cancelled."""
    known: Answers = {}
    while True:
        for robot, answer in (await gates.ask(bus, keys.gate_status, run, robots)).items():
            if _state(answer) != _state(known.get(robot)):
                say(f"robot {robot}: {gates.words(answer)}")
            known[robot] = answer
        await asyncio.sleep(WATCH)


def _state(answer: Answer | None) -> str | None:
    return None if answer is None else gates.words(answer)
