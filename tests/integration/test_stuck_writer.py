"""A process that writes a log, but makes no progress, ends its run with one line."""

import os
import signal
from pathlib import Path

import pytest

from console.backends import inprocess
from fes.errors import FesError
from fes.recording.writer import connection
from tests.support.loop import load
from world.execution.recorder import Recorder


@pytest.mark.parametrize("where", ["in a request", "while it is behind"])
def test_a_writer_that_makes_no_progress_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    monkeypatch.setattr(connection, "PATIENCE", 1)
    pair = load("pair.toml", run__duration=60.0)
    rule = r"run\.mcap: the process that writes it made no progress for 1 s$"
    with pytest.raises(FesError, match=rule), Recorder(tmp_path / "run.mcap", pair, "test", "inprocess") as recorder:  # noqa: PT012
        recorder.pause()
        assert isinstance(recorder._log, connection.LogWriter)
        os.kill(recorder._log.pid, signal.SIGSTOP)
        if where == "in a request":
            recorder.pause()
        else:
            monkeypatch.setattr(connection, "BACKLOG", 1 << 16)
            inprocess.run(pair, "test", recorder=recorder)
