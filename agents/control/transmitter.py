"""What goes on the air: what a robot says, unless its transmitter is late or damages it.

A late transmitter sends what it was given some ticks ago, stamped as of now: no receiver can tell. A damaged beacon
is none: the world has nobody decode it, and whoever gets its bytes refuses them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fes.arrays import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.errors import MessageError
from fes.model.config import AgentConfig
from fes.model.sensing import Beacons
from fes.protocol import messages

Spoken = tuple[int, bytes, bytes]
"""A robot, and the payloads of its beacon and its command."""


@dataclass(frozen=True, eq=False)
class Transmitters:
    """The transmitters of a crew."""

    seed: int
    late: tuple[tuple[int, int, int], ...]
    """Tick, row and delay from that tick on [ticks], in order of time."""
    damaging: tuple[tuple[int, int, bool], ...]
    """Tick, robot and whether its beacons are damaged from that tick on, in order of time."""


class RepeatedBeacons(NamedTuple):
    """What one transmitter was given at one tick."""

    pose: Floats
    links: Ints
    estimates: Floats
    selected: Bools
    statistics: Floats


Memory = Mapping[int, tuple[RepeatedBeacons, ...]]
"""Row of a late transmitter -> what it was given, the oldest first."""


def of(config: AgentConfig, ids: Ints) -> Transmitters:
    """The transmitters of robots `ids` [n]."""
    rows = {robot: row for row, robot in enumerate(ids.tolist())}
    mine = sorted((fault for fault in config.faults if fault.robot in rows), key=lambda fault: fault.tick)
    late = tuple((fault.tick, rows[fault.robot], fault.delay) for fault in mine)
    damaging = tuple((fault.tick, fault.robot, fault.corrupt) for fault in mine)
    return Transmitters(
        config.seed,
        late if any(fault.delay for fault in mine) else (),
        damaging if any(fault.corrupt for fault in mine) else (),
    )


def send(transmitters: Transmitters, memory: Memory, said: Beacons) -> tuple[Beacons, Memory]:
    """The beacons that go on the air when the robots have `said` this, and what late transmitters then remember.

    One that is not yet as old as its delay sends the oldest that it was given.
    """
    if not transmitters.late:
        return said, memory
    late = {row: delay for row, delay in _now(transmitters.late, said.tick).items() if delay}
    if not late:
        return said, {}
    memory = {
        row: (*memory.get(row, ()), _words(said, row))[-delay - 1 :]  # it may have been longer before
        for row, delay in late.items()
    }
    return _with(said, {row: given[0] for row, given in memory.items()}), memory


def forget(memory: Memory, who: Bools) -> Memory:
    """The memory without that of the robots `who` [n]."""
    return {row: given for row, given in memory.items() if not who[row]}


def damaging(transmitters: Transmitters, tick: int) -> set[int]:
    """The robots whose beacons are damaged at a tick."""
    return {robot for robot, corrupt in _now(transmitters.damaging, tick).items() if corrupt}


def on_air(transmitters: Transmitters, tick: int, spoken: list[Spoken]) -> list[Spoken]:
    """What is spoken, the beacons of damaging transmitters damaged."""
    if not transmitters.damaging:
        return spoken
    broken = damaging(transmitters, tick)
    return [
        (robot, damage(transmitters.seed, tick, robot, beacon) if robot in broken else beacon, command)
        for robot, beacon, command in spoken
    ]


def damage(seed: int, tick: int, robot: int, beacon: bytes) -> bytes:
    """A beacon's payload with bytes flipped, cut short, or garbage of its length: a function of (seed, tick, robot).

    None of it is a beacon. Most flipped bits would give one, of other numbers, as nothing in a beacon is redundant;
    a real radio's checksum finds those out, so bytes are flipped until it is none.
    """
    counter = np.array([0, tick, robot, 0], dtype=np.uint64)
    numbers = np.random.Generator(np.random.Philox(key=draws.key(seed, "damage"), counter=counter))
    kind = numbers.integers(3)
    if kind == 0:
        return beacon[: numbers.integers(len(beacon))]
    broken = bytearray(numbers.bytes(len(beacon)) if kind == 1 else beacon)
    while _is_beacon(bytes(broken)):
        broken[numbers.integers(len(broken))] ^= 1 << int(numbers.integers(8))
    return bytes(broken)


def _now(changes: tuple[tuple[int, int, int], ...], tick: int) -> dict[int, int]:
    """What holds at a tick, of what is set from some ticks on."""
    return {who: value for at, who, value in changes if at <= tick}


def _words(said: Beacons, row: int) -> RepeatedBeacons:
    span = said.links.spans[row]
    links, estimates, named = said.links.peers[span], said.estimates[span], said.selected[span]
    return RepeatedBeacons(said.poses[row], links, estimates, named, said.statistics[row])


def _with(said: Beacons, old: Mapping[int, RepeatedBeacons]) -> Beacons:
    """What was said, the robots at the rows of `old` with other words."""
    poses, statistics, links = said.poses.copy(), said.statistics.copy(), said.links
    for row, words in old.items():
        poses[row], statistics[row] = words.pose, words.statistics
    spans = links.spans
    estimates = [said.estimates[span] for span in spans]
    named = [said.selected[span] for span in spans]
    peers = [links.peers[span] for span in spans]
    for row, words in old.items():
        peers[row], estimates[row], named[row] = words.links, words.estimates, words.selected
    together = np.concatenate(peers)
    if together.tobytes() != links.peers.tobytes() or any(
        len(words.links) != links.counts[row] for row, words in old.items()
    ):
        links = Edges(links.ids, np.repeat(np.arange(len(peers)), [len(some) for some in peers]), together)
    return replace(
        said,
        poses=poses,
        links=links,
        estimates=np.concatenate(estimates),
        selected=np.concatenate(named),
        statistics=statistics,
    )


def _is_beacon(payload: bytes) -> bool:
    try:
        messages.decode_beacon(payload)
    except MessageError:
        return False
    return True
