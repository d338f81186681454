"""Payloads that break one rule each, packed by hand: what is refused, and in which words."""

import math
from typing import Any

import msgpack
import pytest

from fes.protocol import wire
from tests.support.payloads import CODECS, refusal
from tests.support.plain_payloads import PLAIN, PROTOCOL, TEAM, float64, int32, int64

NAMES = list(CODECS)


BIG = b"\0" * (wire.MAX_PAYLOAD + 1)

BROKEN: list[tuple[str, int, Any, str]] = [
    *((name, 0, version, f"protocol {PROTOCOL}") for name in PLAIN for version in (0, 2, None, "3", [3])),
    *((name, 1, BIG, "longer than 1048576 bytes") for name in PLAIN),
    *((name, 1, tick, "tick") for name in NAMES[:3] for tick in (-1, 2**53, 1.0, True, None)),
    *((name, 2, robot, "robot") for name in NAMES[:3] for robot in (-1, 2**31, 4.0, False)),
    *((name, 3, x, "finite") for name in NAMES[:3] for x in (math.nan, math.inf, -math.inf, 1, True)),
    *(("Beacon", 6, ids, "ascend") for ids in (int32(9, 2), int32(-1, 2), int32(2, 2))),
    *(("Beacon", 6, ids, "int32") for ids in (b"123", [2, 9], "abcd", None)),
    *(("Beacon", 7, value, "2 float64") for value in (b"", float64(1.0), float64(1.0) + b"1", [60.0, 70.0])),
    *(("Beacon", 7, float64(1.0, bad), "finite") for bad in (math.nan, math.inf, -math.inf)),
    *(("Command", 6, float64(1.0, bad), "finite") for bad in (math.nan, math.inf)),
    *(
        ("Command", 7, value, "equally many numbers for each link")
        for value in (float64(1.0), float64(1.0, 2.0, 3.0))
    ),
    *(("Command", 7, value, "at most 32 float64") for value in (b"1", float64(*range(33)), [1.0] * 4)),
    *(("Command", 8, value, "at most 64 float64") for value in (b"1", float64(*range(65)), [1.0], None)),
    *(("Command", 8, float64(bad), "finite") for bad in (math.nan, math.inf)),
    *(("Command", 9, is_free, "flag") for is_free in (0, 1, "", b"")),
    *(("Command", 7, float64(1.0, 2.0, 3.0, bad), "finite") for bad in (math.nan, math.inf)),
    *(("Beacon", 9, value, "64 float64") for value in (b"1", [1.0], float64(*range(65)))),
    *(("Beacon", 9, float64(bad), "finite") for bad in (math.nan, math.inf)),
    *(("Beacon", 10, value, "at most 256 bytes") for value in (bytes(257), "a", [1], None)),
    *(("Beacon", 8, value, "codes") for value in (b"\1", b"\1\2", b"\1\0\0", [1, 0])),
    *(("Observation", 7, codes, "codes") for codes in (b"", b"\1\3", "\1\1")),
    *(("Observation", 8, over, "flag") for over in (0, 1, None, "")),
    *(("Observation", 9, since, "tick") for since in (-1, 1.0, None)),
    *(("Observation", 10, fixed, "tick") for fixed in (-1, 1.0, None)),
    ("Observation", 10, 8, "expects a pose measured at its tick or before"),
    *(("Join", 1, ids, "ascend") for ids in ([5, 4], [4, 4])),
    *(("Join", 1, ids, "robot") for ids in ([], 4, [-1], [True], [2**31], [1.0], {"a": 4})),
    *(("Join", 2, agent, "number for the agent") for agent in (-1, True, 1.0, None, 2**62 + 1)),
    *(("Join", 3, arithmetic, "arithmetic") for arithmetic in (None, 7, b"a", "a\nb", "a" * 201)),
    *(("Report", 4, numbers, "numbers") for numbers in ([], [1.0] * 6, [1] * 7, [True] * 7, None)),
    *(("Report", 5, alive, "code") for alive in (b"\1\2", [1, 0])),
    *(("Report", 6, poses, "float64") for poses in (float64(1.0), b"")),
    *(("Report", 6, float64(1, 2, 3, 4, 5, bad), "finite") for bad in (math.nan, math.inf)),
    ("Report", 8, int32(1, 0), "two ends"),
    *(("Report", at, int32(robot), "between its 2 robots") for at in (7, 8) for robot in (2, -1, 2**31 - 1)),
    *(("Recall", 1, tick, "tick") for tick in (-1, 2**53, 7.0, None, b"7")),
    *(("Change", 1, path, "expects a field") for path in ("", "a\nb", 4, None, "a" * 201, "a.a.a.a.a.a.a.a.a")),
    *(("Change", 2, value, "value as JSON") for value in ("", "{", "[" * 4000, b"1", 1, "1" * 4097, None)),
    *(("Effect", 4, optimal, "finite") for optimal in (math.inf, -math.inf, 68)),
    *(("Effect", 3, tick, "tick") for tick in (-1, 1.0)),
    *(("About", at, text, "version") for at in (1, 2) for text in (1, None, "1\n2", "1" * 101)),
    *(("About", 3, robots, "number of robots") for robots in (0, -1, 2**31, 1.0, True)),
    *(("About", 4, clock, "finite") for clock in (math.nan, math.inf, 1)),
    *(("RobotReport", 1, boot, "number of a start") for boot in (-1, 2**62 + 1, 1.0, True, None)),
    *(("RobotReport", 2, time, "a time from 0 to 1e+09") for time in (-1.0, 2e9, math.nan, math.inf, 1)),
    *(("RobotReport", 3, dt, "a tick length") for dt in (0.0, -0.02, 1e-5, 11.0, math.nan, 1)),
    *(("RobotReport", 4, pose, "a pose") for pose in ([1.0, 2.0], b"", None)),
    *(("RobotReport", 4, [0.0, bad, 0.0], "finite") for bad in (math.nan, math.inf, 1)),
    *(("RobotReport", 5, age, "the age of a pose") for age in (-0.5, -1, math.nan, 2e9)),
    *(("RobotReport", 6, command, "Command") for command in (b"", b"\x90", 7, None)),
    *(("RobotReport", 7, scale, "a separation") for scale in (-1.0, math.nan, 75)),
    *(("RobotReport", 8, ids, "ascend") for ids in (int32(9, 2), int32(-1, 2))),
    ("RobotReport", 8, int32(*range(4097)), "at most 4096 peers"),
    *(("RobotReport", 9, counts, "heard, missed and concealed") for counts in ([], [b""] * 2, b"")),
    *(("RobotReport", 9, [int64(1, 2), blob, int64(1, 2)], "2 int64") for blob in (b"", int64(1), [1, 2])),
    *(("RobotReport", 9, [int64(1, bad)] * 3, "counts from 0 to 4294967296") for bad in (-1, 2**32 + 1)),
    *(("RobotReport", 10, blob, "2 float64") for blob in (b"", float64(1.0), [1.0, 2.0])),
    ("RobotReport", 10, float64(1.0, math.inf), "finite, or NaN"),
    *(("RobotReport", 11, mode, "mode") for mode in ("walking", 1, None, ["held"])),
    *(("RobotReport", 12, reason, "one line") for reason in ("a\nb", "a" * 201, b"fence", None)),
    *(("Permit", 1, operator, "an operator") for operator in (-1, 2**62 + 1, True, 1.0)),
    *(("Permit", 2, sequence, "tick") for sequence in (-1, 2**53, 1.0, None)),
    *(("GateStatus", 2, mode, "a mode") for mode in ("", "walking", 1, None)),
    *(("GateStatus", 9, clock, "reading of a clock") for clock in (-1, 2**62 + 1, 1.0, True, None)),
    *(("Start", 1, clock, "reading of a clock") for clock in (-1, 2**62 + 1, 1.0, True, None)),
    *(("GateStatus", 3, reason, "one line") for reason in ("a\nb", "a" * 201, b"fence", None)),
    ("Join", 1, list(range(100_001)), "list of robots"),
    ("Report", 9, [float64(1.0)] * 9, "link arrays"),
    ("Report", 9, [float64(1.0, 2.0)] * 10, "1 float64"),
    ("Report", 12, 1, "flag"),
    *(("Report", 13, value, "missed and late") for value in ([], [b""], b"", None)),
    *(("Report", 13, [b"", value], "2 int64, or none") for value in (b"1", bytes(8), bytes(24), None)),
]


@pytest.mark.parametrize("name", PLAIN)
def test_the_layout_is_the_version_and_the_fields_in_order(name: str) -> None:
    payload: bytes = msgpack.packb(PLAIN[name])
    assert CODECS[name].encode(CODECS[name].decode(payload)) == payload


@pytest.mark.parametrize(("name", "at", "value", "rule"), BROKEN)
def test_a_broken_field_is_rejected_with_its_rule(name: str, at: int, value: Any, rule: str) -> None:
    fields = PLAIN[name].copy()
    fields[at] = value
    message = refusal(name, msgpack.packb(fields))
    assert message is not None
    assert rule in message


def test_only_a_report_without_an_end_holds_robots_whose_pose_is_unknown() -> None:
    fields = [*PLAIN["Report"][:3], 0, *PLAIN["Report"][4:]]
    fields[6] = float64(1, 2, 3, math.nan, math.nan, math.nan)
    decoded = CODECS["Report"].decode(msgpack.packb(fields))
    assert decoded.is_of_robots
    assert [math.isnan(x) for x in decoded.poses[:, 0]] == [False, True]
    fields[3] = 9
    assert "finite" in str(refusal("Report", msgpack.packb(fields)))


@pytest.mark.parametrize("name", PLAIN)
def test_a_missing_or_an_additional_field_is_rejected(name: str) -> None:
    most = [*PLAIN[name], TEAM] if name == "Report" else PLAIN[name]
    for fields in (PLAIN[name][:-1], [*most, 0]):
        assert f"expects {len(PLAIN[name]) - 1} fields" in str(refusal(name, msgpack.packb(fields)))


def test_a_report_with_the_team_index_has_one_more_field() -> None:
    payload: bytes = msgpack.packb([*PLAIN["Report"], TEAM])
    decoded = CODECS["Report"].decode(payload)
    assert (decoded.cutting.tolist(), decoded.slots.tolist(), decoded.plans.tolist()) == ([1], [-1, 0], [2, 0])
    assert CODECS["Report"].encode(decoded) == payload


@pytest.mark.parametrize(
    ("at", "value", "rule"),
    [
        *((0, numbers, "numbers") for numbers in ([], [1.0] * 4, [1, 1, 1], None)),
        *((1, ids, "int32") for ids in (b"1", [1], None)),
        (1, int32(2), "between its 2 robots"),
        *((at, blob, "2 int32, or none") for at in (2, 3) for blob in (int32(0), b"1", [0, 0])),
        *((2, int32(0, slot), "numbers from -1 to 1") for slot in (-2, 2)),
        *((3, int32(0, plan), "numbers from 0 to 2") for plan in (-1, 3)),
    ],
)
def test_a_broken_part_of_the_team_index_is_rejected_with_its_rule(at: int, value: Any, rule: str) -> None:
    team = TEAM.copy()
    team[at] = value
    assert rule in str(refusal("Report", msgpack.packb([*PLAIN["Report"], team])))
    assert "four parts" in str(refusal("Report", msgpack.packb([*PLAIN["Report"], team[:3]])))


@pytest.mark.parametrize(
    ("robots", "config", "rule"),
    [
        ([], "{}", "list of robots"),
        ([-1], "{}", "robot must"),
        ([0], "", "configuration"),
        ([0], "[" * 5000, "configuration"),
        ([0], '{"dt": NaN}', "configuration"),
        ([0], "x" * 5000, "configuration"),
        ([0], b"{}", "JSON"),
    ],
)
def test_a_welcome_without_a_configuration_is_rejected(robots: list[int], config: object, rule: str) -> None:
    assert rule in str(refusal("Welcome", msgpack.packb([PROTOCOL, robots, config])))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("depth", [10, 200, 1000, 1020, 100_000])
def test_deeply_nested_lists_are_rejected(name: str, depth: int) -> None:
    fields = CODECS[name].fields
    assert refusal(name, b"\x91" * depth + b"\xc0")
    assert refusal(name, bytes([0x91 + fields, 1]) + b"\x91" * depth + b"\xc0" * fields)


@pytest.mark.parametrize("version", [True, 1.0])
def test_a_version_that_is_not_an_integer_is_rejected(version: object) -> None:
    assert refusal("Join", msgpack.packb([version, *PLAIN["Join"][1:]]))
