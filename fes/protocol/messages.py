"""Messages between world and agents, one robot at a time.

A decoder raises MessageError, and nothing else, on any bytes.
"""

from typing import NamedTuple

import numpy as np
from pydantic import ValidationError

from fes.arrays.types import Bytes, Floats, Ints
from fes.errors import MessageError
from fes.model.config import AgentConfig
from fes.model.sensing import (
    DECODED,
    MAX_DECLARED,
    MAX_DETAILS,
    MAX_LEARNT,
    MAX_NUMBER,
    MAX_STATISTICS,
    MAX_TWIST,
)
from fes.protocol import packing, wire

MAX_AGENT = 2**62
"""Largest number of an agent in a Join."""

MAX_ARITHMETIC = 200
"""Longest description of an arithmetic [characters]."""


class Join(NamedTuple):
    """An agent's request for a Welcome. It is repeated later, to confirm that the Welcome still holds."""

    robots: tuple[int, ...]
    """The robots that it wants to host, ascending."""
    agent: int
    """A number that it has drawn, from 0 to MAX_AGENT: no other agent of these robots has the same."""
    arithmetic: str = ""
    """The agent's arithmetic, as `fes.system.fingerprint.text` describes it; empty if the agent does not state it."""

    @property
    def mark(self) -> bytes:
        """The mark beside each of its Commands: another process with the same certificate does not know it."""
        return self.agent.to_bytes(8, "little")


class Welcome(NamedTuple):
    """World to agent, once per join: the robots that it hosts, and all that it may know."""

    robots: tuple[int, ...]
    config: AgentConfig


class Observation(NamedTuple):
    """World to robot, each tick: the robot's measurements. `over` ends the run and expects no answer."""

    tick: int
    robot: int
    pose: tuple[float, float, float]
    """x, y, heading [m, m, rad; world frame]."""
    in_range: Ints
    """Peers within communication range, ascending [c]."""
    reception: Bytes
    """Reception of their beacons of the previous tick: CLOSED, LOST or DECODED [c]."""
    over: bool
    since: int
    """Tick from which the robot takes part. If it has changed, the robot was absent, and starts without state."""
    fixed: int | None = None
    """Tick at which `pose` was measured, at most `tick`: earlier where a fix is old or held. None: at `tick`."""


class Beacon(NamedTuple):
    """Robot to the peers in range, each tick."""

    tick: int
    robot: int
    pose: tuple[float, float, float]
    """x, y, heading [m, m, rad; world frame]."""
    links: Ints
    """Peers to which it has a link, ascending [l]."""
    estimates: Floats
    """Its separation estimate of each link [l] [m]."""
    selected: Bytes
    """1 where its own neighbor rule chose the link [l]."""
    statistics: Floats
    """Numbers of its seeking law [q]; empty if it has none."""
    declared: bytes = b""
    """Bytes that its laws declared: first those of its formation law, then those of its seeking law."""


class Command(NamedTuple):
    """Robot to its body, each tick: the twist to hold, and telemetry for observers, which does not affect motion."""

    tick: int
    robot: int
    twist: tuple[float, float]
    """linear, angular [m/s, rad/s; body frame]."""
    links: Ints
    """As in the beacon [l]."""
    estimates: Floats
    """As in the beacon [l] [m]."""
    learnt: Floats
    """Numbers that it has learnt [k l], one row after the other over its links, as the seeking law names them."""
    details: Floats = np.zeros(0)
    """Further numbers [j], as the formation law names them."""
    is_model_free: bool | None = None
    """True if its process has not loaded the channel's formula; None where that is not known."""


def encode_observation(message: Observation) -> bytes:
    """The payload of an Observation."""
    in_range, reception = wire.id_bytes(message.in_range), message.reception.tobytes()
    fixed = message.tick if message.fixed is None else message.fixed
    return packing.pack_observation(
        message.tick, message.robot, message.pose, in_range, reception, message.over, message.since, fixed
    )


def decode_observation(payload: bytes) -> Observation:
    """The Observation in a payload."""
    name = "Observation"
    tick, robot, x, y, heading, in_range, reception, over, since, fixed = wire.unpack(name, payload, 10)
    peers = wire.ids(name, in_range)
    stamp = wire.stamp(name, tick, robot)
    wire.check(name, wire.tick(name, fixed) <= tick, "expects a pose measured at its tick or before", fixed)
    return Observation(
        *stamp,
        wire.finite(name, (x, y, heading)),
        peers,
        wire.codes(name, reception, len(peers), DECODED),
        wire.flag(name, over),
        wire.tick(name, since),
        fixed,
    )


def encode_beacon(message: Beacon) -> bytes:
    """The payload of a Beacon."""
    return packing.pack_beacon(
        message.tick,
        message.robot,
        message.pose,
        wire.id_bytes(message.links),
        message.estimates.tobytes(),
        message.selected.tobytes(),
        message.statistics.tobytes(),
        message.declared,
    )


def decode_beacon(payload: bytes) -> Beacon:
    """The Beacon in a payload."""
    name = "Beacon"
    tick, robot, x, y, heading, links, estimates, selected, statistics, declared = wire.unpack(name, payload, 10)
    peers = wire.ids(name, links)
    return Beacon(
        *wire.stamp(name, tick, robot),
        wire.finite(name, (x, y, heading), MAX_NUMBER),
        peers,
        wire.numbers(name, estimates, len(peers), MAX_NUMBER),
        wire.codes(name, selected, len(peers), 1),
        wire.some_numbers(name, statistics, MAX_STATISTICS, MAX_NUMBER),
        wire.some_bytes(name, declared, MAX_DECLARED),
    )


def encode_command(message: Command) -> bytes:
    """The payload of a Command."""
    return packing.pack_command(
        message.tick,
        message.robot,
        message.twist,
        wire.id_bytes(message.links),
        message.estimates.tobytes(),
        message.learnt.tobytes(),
        message.details.tobytes(),
        message.is_model_free,
    )


def decode_command(payload: bytes) -> Command:
    """The Command in a payload."""
    name = "Command"
    tick, robot, linear, angular, links, estimates, learnt, details, is_free = wire.unpack(name, payload, 9)
    peers = wire.ids(name, links)
    parameters = wire.some_numbers(name, learnt, MAX_LEARNT * len(peers), MAX_NUMBER)
    is_whole = len(parameters) % len(peers) == 0 if len(peers) else len(parameters) == 0
    wire.check(name, is_whole, "expects equally many numbers for each link", len(parameters))
    return Command(
        *wire.stamp(name, tick, robot),
        wire.finite(name, (linear, angular), MAX_TWIST),
        peers,
        wire.numbers(name, estimates, len(peers), MAX_NUMBER),
        parameters,
        wire.some_numbers(name, details, MAX_DETAILS, MAX_NUMBER),
        None if is_free is None else wire.flag(name, is_free),
    )


def encode_welcome(message: Welcome) -> bytes:
    """The payload of a Welcome."""
    return wire.pack(list(message.robots), message.config.model_dump_json())


def decode_welcome(payload: bytes) -> Welcome:
    """The Welcome in a payload."""
    name = "Welcome"
    robots, config = wire.unpack(name, payload, 2)
    hosted = wire.robot_list(name, robots)
    wire.check(name, isinstance(config, str), "expects the configuration as JSON", config)
    try:
        return Welcome(hosted, AgentConfig.model_validate_json(config))
    except ValidationError as error:
        raise MessageError(name, f"configuration: {error.errors()[0]['msg']}") from None


def encode_join(join: Join) -> bytes:
    """The payload of a Join."""
    return wire.pack(list(join.robots), join.agent, join.arithmetic)


def decode_join(payload: bytes) -> Join:
    """The Join in a payload."""
    name = "Join"
    robots, agent, arithmetic = wire.unpack(name, payload, 3)
    wire.check(name, type(agent) is int and 0 <= agent <= MAX_AGENT, "expects a number for the agent", agent)
    is_short = type(arithmetic) is str and len(arithmetic) <= MAX_ARITHMETIC and arithmetic.isprintable()
    wire.check(name, is_short, "expects its arithmetic in a few words", arithmetic)
    return Join(wire.robot_list(name, robots), agent, arithmetic)


def encode_lease(robot: int) -> bytes:
    """The payload of a Lease: the robot that an agent may ask to host."""
    return wire.pack(robot)


def decode_lease(payload: bytes) -> int:
    """The robot in a Lease."""
    [robot] = wire.unpack("Lease", payload, 1)
    return wire.robot_id("Lease", robot)


def encode_recall(tick: int) -> bytes:
    """The payload of a Recall: a request to resend a robot's beacon of a tick."""
    return wire.pack(tick)


def decode_recall(payload: bytes) -> int:
    """The tick whose beacon is wanted."""
    [tick] = wire.unpack("Recall", payload, 1)
    return wire.tick("Recall", tick)
