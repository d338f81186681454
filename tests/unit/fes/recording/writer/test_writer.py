"""The writer of a log, without its process: frames in pieces, frames that were cut, and requests."""

import os
import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.errors import FesError
from fes.recording import ticks
from fes.recording.writer import frames, process
from fes.recording.writer.log_file import LogFile

PAYLOADS = [frames.PAYLOADS, [b"o", b""], [b"b", b""], [b"c", b""]]


@given(st.lists(st.binary(max_size=40), max_size=5), st.integers(1, 30))
def test_frames_arrive_whole_however_the_stream_is_cut(contents: list[bytes], piece: int) -> None:
    stream = b"".join(frames.pack(number, content) for number, content in enumerate(contents))
    splitter = frames.Splitter()
    result: list[list[Any]] = []
    for place in range(0, len(stream), piece):
        result += splitter.feed(stream[place : place + piece])
    assert result == [[number, content] for number, content in enumerate(contents)]


def serve(path: Path, stream: bytes) -> list[list[Any]]:
    """Let a writer read a stream to its end; returns its answers."""
    incoming, to_writer = os.pipe()
    answers, outgoing = os.pipe()
    os.write(to_writer, stream)
    os.close(to_writer)
    try:
        process.serve(LogFile(path), incoming, outgoing)
    finally:
        os.close(outgoing)
        os.close(incoming)
        received = os.read(answers, 1 << 16)
        os.close(answers)
    return list(frames.Splitter().feed(received))


def logged(path: Path) -> list[int]:
    """The ticks in a log."""
    return [message.sequence for topic, message in ticks.messages(path) if topic == "/commands"]


def test_a_stream_that_ends_leaves_all_whole_ticks(tmp_path: Path) -> None:
    whole = [frames.pack(0, "write", tick, 20 * tick, [PAYLOADS]) for tick in range(3)]
    for cut in (0, 1, 8, len(whole[2]) - 1):
        path = tmp_path / f"{cut}.mcap"
        assert serve(path, b"".join(whole[:2]) + whole[2][:cut]) == []
        assert logged(path) == [0, 1]


def test_a_request_is_answered_after_all_ticks_before_it(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    stream = frames.pack(0, "write", 0, 0, [PAYLOADS]) + frames.pack(7, "position")
    [[request, [size, sha256]]] = serve(path, stream)
    assert request == 7
    assert size == path.stat().st_size
    assert len(sha256) == 64
    stream += frames.pack(8, "finish", {"ended": "it was stopped"}) + frames.pack(9, "position")
    assert [answer[0] for answer in serve(path, stream)] == [7, 8]  # after its end it reads no more


def test_an_error_of_the_file_ends_the_writer(tmp_path: Path) -> None:
    stream = frames.pack(0, "write", 0, 0, [PAYLOADS]) + frames.pack(1, "position")
    with pytest.raises(FesError, match=r"^cannot write /dev/full: No space left on device$"):
        serve(Path("/dev/full"), stream)


def test_packed_payloads_leave_the_same_file(tmp_path: Path) -> None:
    packed = [frames.PACKED, b"obc", struct.pack("=6q", 1, 1, 2, 2, 3, 3)]
    for name, messages in (("packed", packed), ("each", PAYLOADS)):
        stream = b"".join(frames.pack(0, "write", tick, 20 * tick, [messages]) for tick in range(3))
        serve(tmp_path / name, stream + frames.pack(1, "finish", {"ended": "at its end"}))
    assert (tmp_path / "packed").read_bytes() == (tmp_path / "each").read_bytes()


def test_a_field_that_cannot_be_packed_leaves_no_bytes_in_the_next_frame() -> None:
    with pytest.raises(TypeError, match="serialize"):
        frames.pack(0, "write", [b"x" * 40, object()])
    assert list(frames.Splitter().feed(frames.pack(1, "position"))) == [[1, "position"]]
