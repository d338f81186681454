"""Files crafted to be expensive are rejected in one line, in bounded time and memory."""

import hashlib
import json
import os
import subprocess
from pathlib import Path

import pytest

from console.connect import run_directory
from console.replay import log
from fes.errors import FesError
from fes.extension import registry
from fes.recording import layout, mcap_file, messages_pb2, records
from fes.recording.mcap_file import McapFile
from fes.recording.records import Reader
from fes.system import files, fingerprint, strict_json
from fes.transport.endpoints import DEFAULT_ENDPOINT
from tests.support import crafted, recordings
from tests.support.loop import load
from tests.support.processes import PATIENCE, command
from world.execution import recorder, snapshot
from world.execution.recorder import Recorder

MOST = 512.0
"""Memory that the reader of one of them may use [MiB]; a chunk unpacks to 64, and the interpreter uses 80."""


def test_crafted_files_are_rejected_in_one_line_each_and_with_little_memory(tmp_path: Path) -> None:
    crafted.write(tmp_path)
    done = subprocess.run(
        command("tests.support.untrusted", str(tmp_path)),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    result = json.loads(done.stdout)
    tried = {(kind, name) for kind, made in crafted.FILES.items() for name in made}
    assert {(kind, name) for kind, name, _ in result["ends"]} == tried
    for kind, name, line in result["ends"]:
        assert line, f"{kind}, {name}: not refused"
        assert "\n" not in line
        assert line.isprintable()
    assert result["peak"] < MOST


def test_endless_files_are_rejected_without_waiting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    place = Path("runs/x") / run_directory.ENDPOINT
    place.parent.mkdir(parents=True)
    os.mkfifo(place)
    assert run_directory.find("main").endpoint == DEFAULT_ENDPOINT
    for path in (place, Path("/dev/zero")):
        for read in (log.load, snapshot.read):
            with pytest.raises(FesError, match=rf"^{path}: is not a regular file$"):
                read(path)


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "state").open("wb") as file:
        file.truncate(snapshot.LARGEST + 1)  # a sparse file: it uses no space on the disk
    with pytest.raises(FesError, match=r"state: is larger than 1,073,741,824 bytes$"):
        snapshot.read(tmp_path / "state")
    (tmp_path / "table").write_bytes(b"x" * (files.MAX_TABLE + 1))
    with pytest.raises(FesError, match=r"table: is larger than 1,048,576 bytes$"):
        files.read_table(tmp_path / "table")


def test_no_file_is_written_that_a_reader_would_reject(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert records.LIMIT * 63 // 64 >= mcap_file.LARGEST > 10 * mcap_file.CHUNK
    monkeypatch.setattr(mcap_file, "LARGEST", 1000)
    file = McapFile(tmp_path / "run.mcap")
    file.put("/x", messages_pb2.Report, bytes(1001), 0, 0)
    with pytest.raises(
        FesError, match=r"a tick takes 1,032 bytes, of at most 1,000: --no-record runs without a log$"
    ):
        file.settle(at_once=True)
    file.finish("end", {})


def test_no_log_is_written_that_unpacks_to_more_than_a_reader_accepts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(records, "FREE", 1 << 20)
    monkeypatch.setattr(records, "RATIO", 200)
    path = tmp_path / "run.mcap"
    file = McapFile(path)
    with pytest.raises(FesError, match=r"it is so uniform that [\d,]+ bytes take [\d,]+: --no-record runs"):  # noqa: PT012
        for tick in range(1000):
            file.put("/x", messages_pb2.Report, bytes(20_000), tick, tick)
            file.settle(at_once=True)
    file.finish("end", {})
    assert sum(1 for block in Reader(path) for _ in block) > 20  # the part that was written before is read


def test_a_summary_too_large_for_a_reader_is_written_to_the_run_directory_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, pair = tmp_path / "run.mcap", load("pair.toml", run__duration=0.2)
    for limit, kept in ((layout.MAX_JSON, True), (recorder._ENDED + 100, False)):
        monkeypatch.setattr(recorder, "MAX_JSON", limit)
        recordings.record(path, pair)
        loaded = log.load(path)
        assert loaded.ended == "at its end"
        assert (loaded.summary is not None) == kept
    with pytest.raises(FesError, match="a reason"), Recorder(path, pair, "x", "inprocess"):
        raise FesError("a reason " + "x" * 1_000_000)
    assert recordings.messages(path)[-1][0] == "/log"


def test_a_checkpoint_imports_no_module_that_was_not_told_to_be_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package, evil = tmp_path / "wide_package", tmp_path / "evil"
    package.mkdir()
    for name in ("__init__", "law"):
        (package / f"{name}.py").write_text("")
    (package / "danger.py").write_text(f"open({str(evil)!r}, 'w')\nclass Danger:\n    pass\n")
    monkeypatch.syspath_prepend(tmp_path)
    registry.use("wide_package.law")
    head = strict_json.dumps({"fes": "0", "arithmetic": fingerprint.table(), "extensions": []}).encode()
    body = head + b"\ncwide_package.danger\nDanger\n."  # a pickle that is this class
    first = b"fes checkpoint %d" % snapshot.FORMAT
    (tmp_path / "state").write_bytes(b"\n".join([first, hashlib.sha256(body).hexdigest().encode(), body]))
    with pytest.raises(FesError, match=r"state is damaged: UnpicklingError$"):
        snapshot.read(tmp_path / "state")
    assert not evil.exists()
    registry.withdraw("wide_package.law")
