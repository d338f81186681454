"""Results of another arithmetic are never taken for results of this one."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import compare, log
from console.replay.recorded import Mismatch
from console.sweep import cluster, design, ledger, work
from fes.arithmetic import elementary
from fes.errors import FesError
from fes.protocol import messages, world_info
from fes.system import fingerprint
from tests.support import recordings
from tests.support.arithmetics import OTHER
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.results import written
from tests.support.teams import begun
from world.execution import resume

HERE, THERE = fingerprint.text(), fingerprint.text(OTHER)
VERSION = world_info.version()


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """This process has another arithmetic, as it says."""
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))


def test_every_machine_has_the_expected_fingerprint() -> None:
    table = fingerprint.table()
    assert (table["fingerprint"], table["numpy"]) == (fingerprint.EXPECTED, np.__version__)


@pytest.mark.parametrize(("functions", "core"), [(None, "numpy"), (object(), "c")], ids=["numpy", "c"])
def test_the_core_is_the_one_that_computes_here(
    functions: object, core: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fes.arithmetic.core.functions.load", lambda: functions)
    assert fingerprint.table()["core"] == core


@pytest.mark.parametrize("name", elementary.__all__)
def test_one_bit_of_one_result_of_one_function_changes_the_fingerprint(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    function = getattr(elementary, name)

    def rounded_otherwise(*words: Any) -> Any:
        results = function(*words)
        *others, last = (np.array(result) for result in (results if isinstance(results, tuple) else (results,)))
        last[700] = np.nextafter(last[700], np.inf)
        return (*others, last) if others else last

    assert fingerprint.compute() == fingerprint.EXPECTED
    monkeypatch.setattr(elementary, name, rounded_otherwise)
    assert fingerprint.compute() != fingerprint.EXPECTED


def test_a_processor_that_flushes_subnormal_numbers_to_zero_has_another_fingerprint(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    function, smallest = elementary.log1p, np.finfo(np.float64).smallest_normal

    def flushed(x: Any) -> Any:
        result = function(x)
        return np.where(np.abs(result) < smallest, 0.0, result)

    monkeypatch.setattr(elementary, "log1p", flushed)
    assert fingerprint.compute() != fingerprint.EXPECTED


def test_an_invalid_arithmetic_is_rejected() -> None:
    wrong: list[Any] = [{}, [], None, 3, {**OTHER, "numpy": 2}, {**OTHER, "core": "x" * 41}]
    for arithmetic in [*wrong, {**OTHER, "fingerprint": "\033[31m"}]:
        with pytest.raises((KeyError, TypeError, ValueError)):
            fingerprint.text(arithmetic if arithmetic is not None else 0)  # type: ignore[arg-type]


def test_the_text_and_the_origin_of_an_arithmetic_name_only_what_is_compared() -> None:
    assert fingerprint.text({**OTHER, "core": "compiled"}) == fingerprint.text(OTHER) == "arithmetic 0123456789ab"
    assert fingerprint.origin("0.4.0", OTHER) == "fes 0.4.0 with arithmetic 0123456789ab"
    for unknown in (None, 4, "\033[31m"):
        assert fingerprint.origin(unknown, OTHER) == "arithmetic 0123456789ab"


def test_a_summary_has_the_arithmetic_and_an_expectation_can_name_it(tmp_path: Path) -> None:
    wanted = {"of": "arithmetic.numpy", "equals": np.__version__}
    summary = written(tmp_path, inprocess.run(load("pair.toml", run__duration=0.1, expect=[wanted]), "pair"))
    assert summary["arithmetic"] == fingerprint.table()
    assert [entry["holds"] for entry in summary["expectations"]] == [True]


def test_a_checkpoint_is_not_resumed_with_another_arithmetic(tmp_path: Path, elsewhere: None) -> None:
    state = begun(tmp_path / "run")
    kept = state.read_bytes()
    resume.load(tmp_path / "run")
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(fingerprint, "table", lambda: {**OTHER, "fingerprint": "ba9876543210"})
        with pytest.raises(FesError) as caught:
            resume.load(tmp_path / "run")
    assert str(caught.value) == (
        f"{state} was written by fes {VERSION} with {THERE}; "
        f"this is fes {VERSION} with arithmetic ba9876543210: the digits would differ"
    )
    assert state.read_bytes() == kept


def test_a_run_is_resumed_and_a_sweep_continued_with_another_numpy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(tmp_path / "run")
    planned = design.plan(Path(PAIR), [], "0:1", ["run.duration=0.1"])
    [batch] = work.batches("pair", planned.runs, 1)
    with ledger.opened(tmp_path / "sweep", planned):
        pass
    newer = {**fingerprint.table(), "numpy": "99.0"}
    monkeypatch.setattr(fingerprint, "table", lambda: dict(newer))
    resume.load(tmp_path / "run")
    with ledger.opened(tmp_path / "sweep", planned):
        pass
    assert len(cluster._at_worker((VERSION, HERE), batch)) == 1


def test_a_sweep_is_not_continued_with_another_arithmetic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planned = design.plan(Path(PAIR), [], "0:2", [])
    with ledger.opened(tmp_path, planned):
        pass
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))
    with pytest.raises(FesError) as caught, ledger.opened(tmp_path, planned):
        pass
    assert str(caught.value) == (
        f"--out {tmp_path}: it holds a sweep of another arithmetic; "
        f'sweep.json has arithmetic = "{fingerprint.EXPECTED}", and this is "0123456789ab"'
    )


def test_a_worker_with_another_arithmetic_executes_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    planned = design.plan(Path(PAIR), [], "0:1", ["run.duration=0.1"])
    [batch] = work.batches("pair", planned.runs, 1)
    wanted = world_info.version(), HERE
    assert len(cluster._at_worker(wanted, batch)) == 1
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))
    with pytest.raises(FesError) as caught:
        cluster._at_worker(wanted, batch)
    assert str(caught.value) == f"a Dask worker has {THERE}, and the sweep is of {HERE}"


def test_a_constant_arithmetic_is_not_a_column_of_a_table() -> None:
    assert not [name for name in work.scalars({"ticks": 1, "arithmetic": dict(OTHER)}) if name != "ticks"]


def test_replay_and_compare_distinguish_another_arithmetic_from_an_edited_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    own, foreign, edited = (tmp_path / name for name in ("here.mcap", "there.mcap", "edited.mcap"))
    pair = load("pair.toml", run__duration=0.2)
    recordings.record(own, pair)
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(fingerprint, "table", lambda: dict(OTHER))
        recordings.record(foreign, pair)
    # The digits are the same: no line about the arithmetic.
    assert log.load(foreign).arithmetic == OTHER
    result = replay_command.rerun(log.load(foreign), all_robots=True)
    assert result["arithmetic"] == OTHER  # as it was recorded
    assert compare.compare(own, foreign) == 0
    assert capsys.readouterr().out == "every message of every tick is the same to the bit\n"
    # With a difference, there is one.

    def farther(payload: bytes) -> bytes:
        result = messages.decode_command(payload)
        return messages.encode_command(result._replace(estimates=result.estimates + 1.0))

    recordings.rewrite(foreign, edited, recordings.edited("/commands", 6, 1, farther))
    with pytest.raises(Mismatch, match=r"^tick 6, Command of robot 1: estimates") as caught:
        replay_command.rerun(log.load(edited), all_robots=True)
    assert caught.value.__notes__ == [
        f"recorded by fes {VERSION} with {THERE}; executed by fes {VERSION} with {HERE}"
    ]
    assert "\n" not in str(caught.value)
    assert compare.compare(own, edited) == 1
    output = capsys.readouterr().out.splitlines()
    assert output[1:] == [
        f"A was recorded by fes {VERSION} with {HERE}; B was recorded by fes {VERSION} with {THERE}"
    ]
    assert compare.compare(own, edited, json_=True) == 1
    assert json.loads(capsys.readouterr().out)["arithmetic"] == [fingerprint.table(), OTHER]


def test_a_summary_whose_arithmetic_is_not_that_of_its_log_is_named(tmp_path: Path) -> None:
    summary = recordings.record(tmp_path / "a.mcap", load("pair.toml", run__duration=0.1))
    recordings.rewrite(
        tmp_path / "a.mcap", tmp_path / "b.mcap", lambda *words: words[2], {**summary, "arithmetic": OTHER}
    )
    with pytest.raises(Mismatch, match=r"^summary: arithmetic is "):
        replay_command.rerun(log.load(tmp_path / "b.mcap"))
