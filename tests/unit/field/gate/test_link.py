"""Frames between agent and gate: whole, in order, and without ever waiting."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.errors import MessageError
from fes.protocol.robot_control import HELD, MODES, GateStatus
from field.gate import link
from field.gate.link import TO_AGENT, TO_GATE, Command, FrameSocket, PoseSeen

numbers = st.floats(allow_nan=False)
times = st.integers(0, 2**62)
COMMAND = Command(7, 5_000, 1.5, -0.5, 4_000)


def status(reason: str, mode: str = HELD) -> GateStatus:
    return GateStatus(3, mode, reason, (0.0, 0.0, 0.0), 0.0, (0.5, 1.0), 2, 1)


@given(st.integers(0, 2**64 - 1), times, numbers, numbers, times)
def test_a_command_survives_its_frame(
    sequence: int, computed: int, linear: float, angular: float, heard: int
) -> None:
    command = Command(sequence, computed, linear, angular, heard)
    assert link.decode_command(link.encode_command(command)) == command


@given(times, st.integers(-(2**62), 2**62), st.tuples(numbers, numbers, numbers), st.tuples(numbers, numbers))
def test_a_pose_survives_its_frame(
    received: int, stamp: int, pose: tuple[float, float, float], twist: tuple[float, float]
) -> None:
    seen = PoseSeen(received, stamp, pose, twist)
    frame = link.encode_pose(seen)
    assert len(frame) == TO_AGENT
    assert link.decode_to_agent(frame) == seen


def test_a_pose_without_a_twist_has_nan() -> None:
    decoded = link.decode_to_agent(link.encode_pose(PoseSeen(1, 2, (0.0, 0.0, 0.0), (math.nan, math.nan))))
    assert isinstance(decoded, PoseSeen)
    assert all(map(math.isnan, decoded.twist))


@given(st.text(max_size=300), st.sampled_from(MODES))
def test_a_state_survives_its_frame_and_a_long_reason_is_cut(reason: str, mode: str) -> None:
    reason = reason.encode(errors="ignore").decode()
    frame = link.encode_progress(status(reason, mode))
    assert len(frame) == TO_AGENT
    decoded = link.decode_to_agent(frame)
    assert isinstance(decoded, link.Progress)
    assert decoded._replace(reason="") == link.Progress(mode, "", 2, 1, (0.5, 1.0))
    assert reason.startswith(decoded.reason)
    assert len(decoded.reason.encode()) > link.LONGEST_REASON - 4 or decoded.reason == reason


@given(st.binary(min_size=TO_AGENT, max_size=TO_AGENT), st.binary(min_size=TO_GATE, max_size=TO_GATE))
def test_any_other_frame_is_refused_or_decoded(to_agent: bytes, to_gate: bytes) -> None:
    for decode, frame in ((link.decode_to_agent, to_agent), (link.decode_command, to_gate)):
        try:
            decode(frame)
        except MessageError:
            assert frame[0] not in (link.A_COMMAND, link.A_POSE)


def test_frames_arrive_whole_and_in_order_however_they_are_cut() -> None:
    own, far = link.pair()
    with own, far:
        reader = FrameSocket(far, TO_GATE)
        sent = [COMMAND._replace(sequence=number) for number in range(20)]
        data = b"".join(map(link.encode_command, sent))
        got = []
        for first in range(0, len(data), 37):
            own.send(data[first : first + 37])
            got += reader.receive()
        assert [link.decode_command(frame) for frame in got] == sent


def test_a_far_end_that_does_not_read_never_holds_up_the_sender() -> None:
    own, far = link.pair()
    with own, far:
        writer, reader = FrameSocket(own, TO_GATE), FrameSocket(far, TO_GATE)
        for number in range(5000):
            writer.send(link.encode_command(COMMAND._replace(sequence=number)))
        assert writer.dropped > 0
        got = []
        while frames := reader.receive():
            got += frames
        numbers = [link.decode_command(frame).sequence for frame in got]
        assert numbers == list(range(5000 - writer.dropped))
        assert writer.send(link.encode_command(COMMAND))  # as soon as there is room
        assert not reader.is_closed
        last = reader.receive()
        assert link.decode_command(last[-1]) == COMMAND


def test_the_end_of_one_process_shows_at_the_far_end() -> None:
    own, far = link.pair()
    writer, reader = FrameSocket(own, TO_GATE), FrameSocket(far, TO_AGENT)
    writer.send(link.encode_command(COMMAND))
    writer.close()
    reader.receive()
    reader.receive()
    assert reader.is_closed
    assert not reader.send(b"x" * TO_AGENT)
    reader.close()


@pytest.mark.parametrize("first", [0, 4, 255])
def test_a_frame_of_an_unknown_kind_is_refused(first: int) -> None:
    with pytest.raises(MessageError):
        link.decode_to_agent(bytes([first]) * TO_AGENT)
    with pytest.raises(MessageError):
        link.decode_command(bytes([first]) * TO_GATE)
