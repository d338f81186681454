"""Strategies for messages of every kind with any valid fields, and for any msgpack values."""

import dataclasses
import math
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import msgpack
import numpy as np
from hypothesis import strategies as st

from fes.arrays.types import Floats
from fes.errors import MessageError
from fes.model.config import AgentConfig, ChannelConfig, FormationConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from fes.model.sensing import MAX_DECLARED, MAX_NUMBER, MAX_TWIST
from fes.protocol import channel_change, messages, robot_control, robot_report, world_info
from fes.protocol import report as reports
from fes.protocol.channel_change import ChangeResult, ParameterChange
from fes.protocol.messages import Beacon, Command, Join, Observation, Welcome
from fes.protocol.report import Report
from fes.protocol.robot_control import GateStatus, Permit, Start
from fes.protocol.robot_report import Heard, RobotReport
from fes.protocol.world_info import WorldInfo


class Codec(NamedTuple):
    """Encoder, decoder and strategy of a message, and its number of fields."""

    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Any]
    messages: st.SearchStrategy[Any]
    fields: int


finite = st.floats(allow_nan=False, allow_infinity=False)
reals = st.floats(-MAX_NUMBER, MAX_NUMBER)
rates = st.floats(-MAX_TWIST, MAX_TWIST)
positive = st.floats(0, exclude_min=True, allow_infinity=False)
small = st.floats(1e-3, 1.0)
ticks = st.integers(0, 2**53 - 1)
robots = st.integers(0, 2**31 - 1)
peers = st.lists(robots, unique=True, max_size=6).map(lambda ids: np.array(sorted(ids), dtype=np.int64))


def floats(count: int, numbers: st.SearchStrategy[float] = finite) -> st.SearchStrategy[Floats]:
    return st.lists(numbers, min_size=count, max_size=count).map(lambda values: np.array(values, dtype="<f8"))


def codes(count: int, highest: int) -> st.SearchStrategy[Any]:
    values = st.lists(st.integers(0, highest), min_size=count, max_size=count)
    return values.map(lambda values: np.array(values, dtype=np.uint8))


@st.composite
def observations(draw: st.DrawFn) -> Observation:
    pose, near = (draw(finite), draw(finite), draw(finite)), draw(peers)
    received, over = draw(codes(len(near), 2)), draw(st.booleans())
    tick = draw(ticks)
    return Observation(tick, draw(robots), pose, near, received, over, draw(ticks), draw(st.integers(0, tick)))


@st.composite
def beacons(draw: st.DrawFn) -> Beacon:
    pose, near = (draw(reals), draw(reals), draw(reals)), draw(peers)
    return Beacon(
        draw(ticks),
        draw(robots),
        pose,
        near,
        draw(floats(len(near), reals)),
        draw(codes(len(near), 1)),
        draw(floats(draw(st.integers(0, 7)), reals)),
        draw(st.binary(max_size=MAX_DECLARED)),
    )


@st.composite
def commands(draw: st.DrawFn) -> Command:
    near = draw(peers)
    learnt = draw(floats(draw(st.sampled_from([0, 2 * len(near)])), reals))
    details = draw(floats(draw(st.integers(0, 7)), reals))
    estimates = draw(floats(len(near), reals))
    is_free = draw(st.none() | st.booleans())
    return Command(draw(ticks), draw(robots), (draw(rates), draw(rates)), near, estimates, learnt, details, is_free)


@st.composite
def welcomes(draw: st.DrawFn) -> Welcome:
    low, high = sorted((draw(positive), draw(positive)))
    seeking = OracleConfig(
        index_gain=draw(positive), sub_step=draw(st.floats(1e-9, 0.2)), dither_frequency=draw(st.floats(1e-9, 9.0))
    )
    formation = FormationConfig(linear_limit=draw(st.none() | positive), angular_gain=draw(positive))
    channel = draw(
        st.none() | st.builds(ChannelConfig, reference_snr=positive, path_loss_exponent=st.floats(0.1, 20.0))
    )
    config = AgentConfig(
        dt=draw(positive),
        seed=draw(st.integers(0, 2**53 - 1)),
        objective=ObjectiveConfig(minimum_separation=draw(small), shape_exponent=draw(st.floats(0.1, 20.0))),
        seeking=seeking.model_copy(update={"initial_estimate": (low, high)}),
        formation=formation,
        channel=channel,
    )
    return Welcome(tuple(sorted(draw(st.sets(robots, min_size=1, max_size=5)))), config)


@st.composite
def team_reports(draw: st.DrawFn) -> Report:
    n = draw(st.integers(0, 5))
    links = draw(st.integers(0, 4 if n else 0))
    hints = {field.name: field.type for field in dataclasses.fields(Report) if field.name not in TEAM_FIELDS}
    values: dict[str, Any] = {name: draw(ticks) for name, kind in hints.items() if kind is int}
    values |= {name: draw(st.floats()) for name, kind in hints.items() if kind is float}
    values |= {name: draw(floats(links, st.floats())) for name, kind in hints.items() if kind == Floats}
    for end in ("a", "b"):
        values[end] = np.array(
            draw(st.lists(st.integers(0, max(n - 1, 0)), min_size=links, max_size=links)), dtype=np.int64
        )
    counted = n if draw(st.booleans()) else 0  # the live clock, or lockstep
    counts = st.lists(st.integers(0, 2**53), min_size=counted, max_size=counted)
    values |= {name: np.array(draw(counts), dtype=np.int64) for name in ("missed", "late")}
    values |= {"alive": draw(codes(n, 1)), "poses": draw(floats(3 * n)).reshape(n, 3)}
    team = draw(st.just({}) | team_fields(n))
    return Report(scenario=draw(st.text()), disk_connected=draw(st.booleans()), **values, **team)


TEAM_NUMBERS = ("team_index", "team_index_target", "delivery_after_loss")
TEAM_FIELDS = ("has_team_index", *TEAM_NUMBERS, "cutting", "slots", "plans")


@st.composite
def team_fields(draw: st.DrawFn, n: int) -> dict[str, Any]:
    """The fields of a Report about the team index."""
    cutting = st.lists(st.integers(0, n - 1), max_size=n) if n else st.just([])
    placed = n if draw(st.booleans()) else 0
    lists = {
        "cutting": draw(cutting),
        "slots": draw(st.lists(st.integers(-1, n - 1), min_size=placed, max_size=placed)),
        "plans": draw(st.lists(st.integers(0, 2), min_size=placed, max_size=placed)),
    }
    arrays = {name: np.array(values, dtype=np.int64) for name, values in lists.items()}
    return {"has_team_index": True, **{name: draw(st.floats()) for name in TEAM_NUMBERS}, **arrays}


@st.composite
def robot_reports(draw: st.DrawFn) -> RobotReport:
    near = draw(peers)
    counts = st.lists(st.integers(0, robot_report.MAX_COUNT), min_size=len(near), max_size=len(near))
    numbers = counts.map(lambda each: np.array(each, dtype=np.int64))
    of_peers = draw(numbers), draw(numbers), draw(numbers)
    beacons = Heard(near, *of_peers, draw(floats(len(near), st.floats(allow_infinity=False))))
    return RobotReport(
        draw(st.integers(0, robot_report.MAX_BOOT)),
        draw(spans),
        draw(st.floats(robot_report.SHORTEST_TICK, robot_report.LONGEST_TICK)),
        (draw(finite), draw(finite), draw(finite)),
        draw(spans | st.just(robot_report.NO_AGE)),
        draw(commands()),
        draw(spans),
        beacons,
        draw(st.sampled_from(["", *robot_control.MODES])),
        draw(reasons),
    )


spans = st.floats(0, robot_report.MAX_TIME)
reasons = st.text(st.characters(codec="ascii", categories=["L", "N", "P", "Zs"]), max_size=200)
poses = st.tuples(finite, finite, finite)
gate_states = st.builds(
    GateStatus, robots, st.sampled_from(robot_control.MODES), reasons, poses, finite, st.tuples(finite, finite),
    ticks, ticks, st.integers(0, robot_control.MAX_CLOCK),
)  # fmt: skip
starts = st.builds(Start, st.integers(0, robot_control.MAX_CLOCK))
permits = st.builds(
    Permit, st.integers(0, robot_control.MAX_OPERATOR), ticks, st.integers(0, robot_control.MAX_CLOCK)
)
crews = st.sets(robots, min_size=1, max_size=9).map(lambda ids: tuple(sorted(ids)))
words = st.text(st.characters(codec="ascii", categories=["L", "N", "P"]), max_size=20)
joins = st.builds(Join, crews, st.integers(0, messages.MAX_AGENT), words)

abouts = st.builds(WorldInfo, words, words, st.integers(1, 2**31 - 1), finite)
paths = st.from_regex(r"channel(\.[a-z_]{1,12}){1,3}", fullmatch=True)
settings = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | finite | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)
changes = st.builds(ParameterChange, paths, settings)
optima = finite | st.just(math.nan)  # a trace has no optimal separation
effects = st.builds(ChangeResult, paths, settings, ticks, optima, st.booleans())

CODECS = {
    "Observation": Codec(messages.encode_observation, messages.decode_observation, observations(), 10),
    "Beacon": Codec(messages.encode_beacon, messages.decode_beacon, beacons(), 10),
    "Command": Codec(messages.encode_command, messages.decode_command, commands(), 9),
    "Welcome": Codec(messages.encode_welcome, messages.decode_welcome, welcomes(), 2),
    "Lease": Codec(messages.encode_lease, messages.decode_lease, robots, 1),
    "Join": Codec(messages.encode_join, messages.decode_join, joins, 3),
    "Report": Codec(reports.encode_report, reports.decode_report, team_reports(), 12),
    "Recall": Codec(messages.encode_recall, messages.decode_recall, ticks, 1),
    "Change": Codec(channel_change.encode_change, channel_change.decode_change, changes, 2),
    "Effect": Codec(channel_change.encode_result, channel_change.decode_result, effects, 5),
    "RobotReport": Codec(robot_report.encode_robot_report, robot_report.decode_robot_report, robot_reports(), 12),
    "Permit": Codec(robot_control.encode_permit, robot_control.decode_permit, permits, 3),
    "Start": Codec(robot_control.encode_start, robot_control.decode_start, starts, 1),
    "GateStatus": Codec(robot_control.encode_gate_status, robot_control.decode_gate_status, gate_states, 9),
    "About": Codec(world_info.encode_world_info, world_info.decode_world_info, abouts, 4),
}
scalars = st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text() | st.binary()
odd = st.builds(msgpack.ExtType, st.integers(0, 127), st.binary()) | st.just(msgpack.Timestamp(1, 5))
values = st.recursive(
    scalars | odd, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=3)
)


def refusal(name: str, payload: bytes) -> str | None:
    """Reason why a payload is rejected, in one line; None if it is a message. Other errors pass."""
    try:
        CODECS[name].decode(payload)
    except MessageError as error:
        reason = str(error)
        assert reason.startswith(f"{name}: ")
        assert len(reason) < 200
        assert reason.isprintable()
        return reason
    return None


def bits(value: Any) -> Any:
    """A message as a value that can be compared bit for bit, NaN included."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, float):
        return struct.pack("<d", value)
    if dataclasses.is_dataclass(value):
        return [bits(getattr(value, field.name)) for field in dataclasses.fields(value)]
    if isinstance(value, dict):
        return [(key, bits(item)) for key, item in value.items()]
    return [bits(item) for item in value] if isinstance(value, tuple | list) else value


def assert_refused_or_a_message(name: str, payload: bytes) -> None:
    """Check that a payload is a MessageError, or a message that is encoded to the same bits again."""
    codec = CODECS[name]
    if refusal(name, payload) is None:
        message = codec.decode(payload)
        assert bits(codec.decode(codec.encode(message))) == bits(message)
