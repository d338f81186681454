"""A robot with a valid certificate and faulty beacons is excluded alone, over TLS.

Pass criterion: the others have the same digits as if the schedule had removed the robot at the tick that the journal
names.
"""

import asyncio
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.runtime.outbox import Outbox
from console.backends import inprocess
from console.keys import certificates
from console.replay import command as replay_command
from console.replay import compare, log
from fes.errors import Rejected, Unavailable
from fes.protocol import keys, messages, wire
from fes.recording.layout import NAME
from fes.transport import bus
from fes.transport.bus import Bus
from tests.support import hostile, team_keys
from tests.support.attackers import command, reversioned
from tests.support.hostile import FIRST, HOSTILE, ROBOTS, Attack, Outcome, TickPayloads, scenario
from tests.support.session import RUN
from world.execution import resume
from world.execution.recorder import Recorder
from world.execution.run import EXCLUDE

OTHERS = {robot for robot in range(ROBOTS) if robot != HOSTILE}


@pytest.fixture(scope="module")
def keyed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    roles = ["world", *(f"robot-{robot}" for robot in range(ROBOTS))]
    return team_keys.directory(tmp_path_factory.mktemp("keys"), certificates.create(1.0), roles)


def altered(payload: bytes) -> bytes:
    """The same beacon with another position."""
    beacon = messages.decode_beacon(payload)
    return messages.encode_beacon(beacon._replace(pose=(beacon.pose[0] + 1.0, *beacon.pose[1:])))


def keep(outbox: Outbox, tick: int, said: TickPayloads, beacon: bytes | None) -> None:
    """Store a tick like `say`, with another beacon or without one."""
    outbox._commands[tick] = {robot: payload for robot, _, payload in said}
    if beacon is not None:
        outbox._beacons[tick] = {robot: beacon for robot, _, _ in said}


def mute(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    keep(outbox, tick, said, None)
    outbox._command[HOSTILE](said[0][2])


def junk(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    keep(outbox, tick, said, b"\xc1 junk")
    outbox._beacon[HOSTILE](b"\xc1 junk")
    outbox._command[HOSTILE](said[0][2])


def refuse_the_recall(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    """The beacon is pushed out of every mailbox, and not resent."""
    keep(outbox, tick, said, None)
    outbox._beacon[HOSTILE](said[0][1])
    for _ in range(2 * bus.MAILBOX):
        outbox._beacon[HOSTILE](b"\xc1 junk")
    outbox._command[HOSTILE](said[0][2])


def speak_another_version(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    other = reversioned(said[0][1])
    keep(outbox, tick, said, other)
    outbox._beacon[HOSTILE](other)
    outbox._command[HOSTILE](said[0][2])


def contradict_itself(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    keep(outbox, tick, said, said[0][1])
    outbox._beacon[HOSTILE](said[0][1])
    outbox._beacon[HOSTILE](altered(said[0][1]))
    outbox._command[HOSTILE](said[0][2])


def contradict_itself_later(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    """The second beacon of a tick arrives after the first was checked, and used by peers."""
    if tick > FIRST:
        outbox._beacon[HOSTILE](altered(outbox._beacons[tick - 1][HOSTILE]))
    Outbox.publish(outbox, tick, said)


def speak_ahead(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    """A beacon of a later tick arrives early, and peers might keep it for that tick."""
    if tick == FIRST:
        outbox._beacon[HOSTILE](said[0][1])
        later = messages.decode_beacon(altered(said[0][1]))._replace(tick=tick + 2)
        outbox._beacon[HOSTILE](messages.encode_beacon(later))
        outbox._command[HOSTILE](said[0][2])
        keep(outbox, tick, said, said[0][1])
    else:
        Outbox.publish(outbox, tick, said)


def name_a_stranger(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    """A beacon with a link to a robot that does not exist."""
    beacon = messages.decode_beacon(said[0][1])
    ids, numbers = np.array([500]), np.array([70.0])
    other = beacon._replace(links=ids, estimates=numbers, selected=np.ones(1, dtype=np.uint8))
    keep(outbox, tick, said, messages.encode_beacon(other))
    outbox._beacon[HOSTILE](messages.encode_beacon(other))
    outbox._command[HOSTILE](said[0][2])


NONE = f"robot {HOSTILE}: no readable beacon of tick {FIRST}"
ATTACKS: dict[str, tuple[Attack, int, str]] = {
    "mute": (mute, FIRST, f"{NONE}, and it refused to repeat it: robot 4 does not remember its beacon of tick 40"),
    "junk": (junk, FIRST, f"{NONE}, and it repeated junk: Beacon: is not msgpack (FormatError)"),
    "refused recall": (refuse_the_recall, FIRST, f"{NONE}, and it refused to repeat it: robot 4 does not remember"),
    "wrong version": (speak_another_version, FIRST, f"{NONE}, and it repeated junk: Beacon: {wire.WRONG_VERSION}: 1"),
    "two beacons": (contradict_itself, FIRST, f"robot 4: it sent two different beacons for tick {FIRST}"),
    "ahead of its time": (speak_ahead, FIRST, f"robot 4: it sent a beacon ahead of its time at tick {FIRST}"),
    "a link to no robot": (
        name_a_stranger,
        FIRST,
        f"{NONE}, and it repeated junk: Beacon: has a link to a robot that",
    ),
    "two beacons, one late": (
        contradict_itself_later,
        FIRST + 1,
        f"robot 4: it sent two different beacons for tick {FIRST}",
    ),
}


def without(tick: int, where: Path) -> log.Log:
    """The log of a run in one loop whose schedule removes the hostile robot at a tick."""
    what = scenario(event=[{"at": tick * 0.02, "kill": [HOSTILE]}])
    with Recorder(where / "scheduled.mcap", what, "hostile", "inprocess") as recorder:
        recorder.conclude(inprocess.run(what, "hostile", recorder=recorder))
    return log.load(where / "scheduled.mcap")


def resumed(outcome: Outcome) -> str:
    """The digest of the run, computed again from its first checkpoint and its journal."""
    run, checkpoints, _ = resume.run(outcome.directory, resume.load(outcome.directory), None, 1e9)
    checkpoints.close(run)
    assert HOSTILE in run.excluded
    return run.metrics.link_errors.digest.text()


@pytest.mark.parametrize(("attack", "tick", "reason"), ATTACKS.values(), ids=ATTACKS.keys())
def test_a_faulty_robot_is_excluded_and_the_others_lose_no_digit(
    attack: Attack, tick: int, reason: str, keyed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.runtime.tick_source.QUIET", 0.2)  # its agent asks when it receives nothing
    outcome = hostile.run(tmp_path, keyed, attack)
    excluded = [note for note in outcome.notes if note[0] == EXCLUDE]
    assert [note[1:3] for note in excluded] == [[tick, [HOSTILE]]]
    assert excluded[0][3].startswith(reason)
    recorded, expected = log.load(tmp_path / NAME), without(tick, tmp_path)
    assert compare.first_difference(recorded, expected, OTHERS) is None
    assert outcome.summary["ticks"] == scenario().ticks
    assert outcome.summary["unscheduled_absences"] == scenario().ticks - tick
    assert [robot for robot, error in enumerate(outcome.ended) if error is not None] == [HOSTILE]
    assert str(outcome.ended[HOSTILE]).startswith(f"robot {HOSTILE} is excluded at tick {tick}: {reason}")
    assert replay_command.rerun(recorded, all_robots=True)["digest"] == outcome.summary["digest"] == resumed(outcome)


def honest(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    Outbox.publish(outbox, tick, said)


async def accuse(second: Bus) -> None:
    """Ask the world repeatedly for beacons that arrived, and robots for theirs, as if they had not arrived."""
    for tick in range(FIRST, FIRST + 20):
        for robot in sorted(OTHERS):
            try:
                await second.get(keys.held_beacon(RUN, robot, str(HOSTILE)), messages.encode_recall(tick), 0.2)
            except (Rejected, Unavailable):
                continue
        second._session.get(keys.recall(RUN, 5), payload=messages.encode_recall(tick), timeout=0.1)  # not allowed


def push_out(outbox: Outbox, tick: int, said: TickPayloads) -> None:
    """Junk pushes its beacon out of every mailbox, so that all peers recall it from the world."""
    keep(outbox, tick, said, said[0][1])
    outbox._beacon[HOSTILE](said[0][1])
    for _ in range(2 * bus.MAILBOX):
        outbox._beacon[HOSTILE](b"\xc1 junk")
    outbox._command[HOSTILE](said[0][2])


async def crowd_the_world(second: Bus) -> None:
    """More recall queries from one certificate than the world answers."""
    pending: set[asyncio.Future[bytes]] = set()
    for number in range(3_000):
        query = second.get(keys.held_beacon(RUN, 5, str(HOSTILE)), messages.encode_recall(number), 5.0)
        pending.add(asyncio.ensure_future(query))
        if len(pending) > 300:
            _, pending = await asyncio.wait(pending, return_when=asyncio.FIRST_COMPLETED)
    await asyncio.wait(pending)


def test_a_robot_that_floods_the_world_with_queries_does_not_block_the_answers_to_its_peers(
    keyed: Path, tmp_path: Path
) -> None:
    outcome = hostile.run(tmp_path, keyed, push_out, crowd_the_world)
    assert outcome.ended == [None] * ROBOTS
    assert outcome.summary["digest"] == inprocess.run(scenario(), "hostile")["digest"]


async def flood(second: Bus) -> None:
    """Commands of future ticks at full speed: each would be valid at its tick."""
    put = second.declare_publisher(keys.command(RUN, HOSTILE), "fes.Command")
    for number in range(20_000):
        put(command(number % 200, HOSTILE, 5.0))
        if number % 100 == 0:
            await asyncio.sleep(0)


@pytest.mark.parametrize("beside", [accuse, flood], ids=lambda beside: beside.__name__)
def test_an_accusation_and_a_flood_of_own_commands_exclude_no_robot_and_change_no_digit(
    beside: Any, keyed: Path, tmp_path: Path
) -> None:
    outcome = hostile.run(tmp_path, keyed, honest, beside)
    assert outcome.ended == [None] * ROBOTS
    assert not [note for note in outcome.notes if note[0] == EXCLUDE]
    assert outcome.summary["unscheduled_absences"] == 0
    assert outcome.summary["digest"] == inprocess.run(scenario(), "hostile")["digest"]
    if beside is flood:
        assert outcome.server.rejected_commands > 0
