"""Emulated transmitters, some of them faulty: late, or damaging what they send.

A late transmitter sends data of some ticks ago with the present time stamp, so a receiver cannot tell. By the world's
account, a damaged beacon decodes at no robot. Every process that gets its bytes rejects them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fes.arithmetic import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Bytes, Floats, Ints
from fes.errors import MessageError
from fes.model.config import AgentConfig
from fes.model.sensing import Beacons
from fes.protocol import messages

RobotPayloads = tuple[int, bytes, bytes]
"""A robot, and the payloads of its beacon and its command."""


@dataclass(frozen=True, eq=False)
class Transmitters:
    """The transmitters of a crew."""

    seed: int
    late: tuple[tuple[int, int, int], ...]
    """Tick, row, and delay from that tick on [ticks], in order of time."""
    damaging: tuple[tuple[int, int, bool], ...]
    """Tick, robot, and True if its beacons are damaged from that tick on, in order of time."""


class BeaconContent(NamedTuple):
    """The content that one transmitter was given for its beacon of one tick."""

    pose: Floats
    links: Ints
    estimates: Floats
    selected: Bools
    statistics: Floats
    declared: Bytes


Memory = Mapping[int, tuple[BeaconContent, ...]]
"""Row of a late transmitter -> the contents it was given, the oldest first."""


def of(config: AgentConfig, ids: Ints) -> Transmitters:
    """The transmitters of robots `ids` [n]."""
    rows = {robot: row for row, robot in enumerate(ids.tolist())}
    own = sorted((fault for fault in config.faults if fault.robot in rows), key=lambda fault: fault.tick)
    late = tuple((fault.tick, rows[fault.robot], fault.delay) for fault in own)
    damaging = tuple((fault.tick, fault.robot, fault.corrupt) for fault in own)
    return Transmitters(
        config.seed,
        late if any(fault.delay for fault in own) else (),
        damaging if any(fault.corrupt for fault in own) else (),
    )


def send(transmitters: Transmitters, memory: Memory, beacons: Beacons) -> tuple[Beacons, Memory]:
    """The beacons that are transmitted when the robots hand over `beacons`, and the next memory of late transmitters.

    A transmitter whose memory is shorter than its delay sends the oldest content that it was given.
    """
    if not transmitters.late:
        return beacons, memory
    late = {row: delay for row, delay in _values_at(transmitters.late, beacons.tick).items() if delay}
    if not late:
        return beacons, {}
    memory = {
        row: (*memory.get(row, ()), _content(beacons, row))[-delay - 1 :]  # an earlier delay may have been longer
        for row, delay in late.items()
    }
    return _replaced(beacons, {row: contents[0] for row, contents in memory.items()}), memory


def forget(memory: Memory, restarted: Bools) -> Memory:
    """The memory without that of the robots `restarted` [n]."""
    return {row: contents for row, contents in memory.items() if not restarted[row]}


def damaging(transmitters: Transmitters, tick: int) -> set[int]:
    """The robots whose beacons are damaged at a tick."""
    return {robot for robot, corrupt in _values_at(transmitters.damaging, tick).items() if corrupt}


def on_air(transmitters: Transmitters, tick: int, payloads: list[RobotPayloads]) -> list[RobotPayloads]:
    """The payloads of a tick, after damaging transmitters have damaged their beacons."""
    if not transmitters.damaging:
        return payloads
    faulty = damaging(transmitters, tick)
    return [
        (robot, damage(transmitters.seed, tick, robot, beacon) if robot in faulty else beacon, command)
        for robot, beacon, command in payloads
    ]


def damage(seed: int, tick: int, robot: int, beacon: bytes) -> bytes:
    """A beacon's payload, cut short, with flipped bits, or as random bytes: a function of (seed, tick, robot).

    The result never decodes as a beacon. A beacon has no redundancy, so most flipped bits would give a valid beacon
    with other numbers. A real radio's checksum detects these, so bits are flipped until decoding fails.
    """
    words = draws.words(draws.key(seed, "damage"), tick, robot)
    kind = next(words) % 3
    if kind == 0:
        return beacon[: next(words) % len(beacon)]
    damaged = bytearray(next(words) & 0xFF for _ in beacon) if kind == 1 else bytearray(beacon)
    while _is_beacon(bytes(damaged)):
        damaged[next(words) % len(damaged)] ^= 1 << next(words) % 8
    return bytes(damaged)


def _values_at(changes: tuple[tuple[int, int, int], ...], tick: int) -> dict[int, int]:
    """The latest value of each row or robot at a tick, from changes in order of time."""
    return {subject: value for start, subject, value in changes if start <= tick}


def _content(beacons: Beacons, row: int) -> BeaconContent:
    span = beacons.links.spans[row]
    links, estimates, selected = beacons.links.peers[span], beacons.estimates[span], beacons.selected[span]
    return BeaconContent(
        beacons.poses[row], links, estimates, selected, beacons.statistics[row], beacons.declared[row]
    )


def _replaced(beacons: Beacons, old: Mapping[int, BeaconContent]) -> Beacons:
    """The beacons, with the contents of `old` in its rows."""
    poses, statistics, declared = beacons.poses.copy(), beacons.statistics.copy(), beacons.declared.copy()
    links = beacons.links
    for row, content in old.items():
        poses[row], statistics[row], declared[row] = content.pose, content.statistics, content.declared
    spans = links.spans
    estimates = [beacons.estimates[span] for span in spans]
    selected = [beacons.selected[span] for span in spans]
    peers = [links.peers[span] for span in spans]
    for row, content in old.items():
        peers[row], estimates[row], selected[row] = content.links, content.estimates, content.selected
    all_peers = np.concatenate(peers)
    if all_peers.tobytes() != links.peers.tobytes() or any(
        len(content.links) != links.counts[row] for row, content in old.items()
    ):
        links = Edges(links.ids, np.repeat(np.arange(len(peers)), [len(ids) for ids in peers]), all_peers)
    return beacons._replace(
        poses=poses,
        links=links,
        estimates=np.concatenate(estimates),
        selected=np.concatenate(selected),
        statistics=statistics,
        declared=declared,
    )


def _is_beacon(payload: bytes) -> bool:
    try:
        messages.decode_beacon(payload)
    except MessageError:
        return False
    return True
