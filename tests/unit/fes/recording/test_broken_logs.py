"""Files that are not a complete log: each is one line, for every command."""

import json
from pathlib import Path
from typing import Any

import pytest

from console.replay import command as replay_command
from fes.errors import FesError
from tests.support import recordings
from tests.support.loop import load


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A recorded run of the measured index, and its summary."""
    path = tmp_path_factory.mktemp("replay") / "run.mcap"
    return path, recordings.record(path, load("measured.toml", run__duration=2.0), "measured")


Recorded = tuple[Path, dict[str, Any]]


def bad(path: Path, good: Path, what: str) -> Path:
    """A file that is not a log, or not a complete one."""
    if what == "a text file":
        path.write_text("schema = 1\n")
    elif what == "cut before the first tick":
        path.write_bytes(good.read_bytes()[:4000])
    elif what == "cut":
        path.write_bytes(good.read_bytes()[:-1000])
    elif what == "damaged":
        content = bytearray(good.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(content)
    elif what == "a directory":
        path.mkdir()
    elif what in ("another version", "somebody else's"):

        def edit(topic: str, tick: int, payload: bytes) -> bytes | None:
            if topic != "/scenario":
                return payload
            header = {**json.loads(payload), "log": 9}
            return json.dumps(header).encode() if what == "another version" else None

        recordings.rewrite(good, path, edit)
    return path


BAD = {
    "a text file": "is not a log: it is not an MCAP file",
    "cut before the first tick": "0 of 100 ticks are there",
    "cut": "has no end, its run was killed or the file was cut: 100 of 100 ticks are there",
    "damaged": "the checksum of a chunk differs",
    "a directory": "has no run.mcap: the run was not recorded",
    "another version": "is a log of version 9; this fes reads versions 3 and 4",
    "somebody else's": "is not a log of a run: it does not begin with its scenario",
    "nothing": "No such file or directory",
}


@pytest.mark.parametrize(("what", "rule"), BAD.items(), ids=BAD.keys())
def test_an_incomplete_log_is_rejected_in_one_line(recorded: Recorded, tmp_path: Path, what: str, rule: str) -> None:
    path = bad(tmp_path / "bad", recorded[0], what)
    with pytest.raises(FesError, match=f"^{path}") as caught:
        replay_command.replay(path, json_=True, headless=True)
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)
