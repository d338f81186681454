"""Payloads of ROS 2 messages for tests: valid ones of each kind, and poses to write."""

from typing import Any

from hypothesis import strategies as st

from fes.ros.messages import POSE_KINDS, TWIST_KINDS, PoseMessage, read_pose, read_twist, write_pose, write_twist

KINDS = (*POSE_KINDS, *TWIST_KINDS)
FRAMES = st.text(st.characters(codec="utf-8", categories=("L", "N", "P")), max_size=40)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=64)
HEADINGS = st.floats(-3.141592, 3.141592)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)

POSES = st.builds(
    PoseMessage, STAMPS, FRAMES, NUMBERS, NUMBERS, HEADINGS, st.none() | st.tuples(NUMBERS, NUMBERS)
)  # fmt: skip


def example(kind: str, frame: str = "map", stamp: int = 1_500_000_000) -> bytes:
    """A valid payload of a kind."""
    if kind in TWIST_KINDS:
        return write_twist(kind, 0.25, -1.5, stamp, frame)
    return write_pose(kind, PoseMessage(stamp, frame, 1.25, -2.5, 0.5, (0.125, 0.75)))


def read(kind: str, payload: bytes) -> tuple[Any, ...]:
    """The pose or the twist in a payload of a kind."""
    return read_twist(kind, payload) if kind in TWIST_KINDS else read_pose(kind, payload)
