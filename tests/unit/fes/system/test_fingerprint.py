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


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """This process has another arithmetic, as it says."""
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))


USED = ["exp", "expm1", "log", "log1p", "logaddexp", "sin", "cos", "tan", "arctan", "arctan2", "power", "sqrt"]
USED += ["einsum", "bincount", "linalg.eigvalsh"]


@pytest.mark.parametrize("name", USED)
def test_one_bit_of_one_result_of_one_function_changes_the_fingerprint(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    *path, last = name.split(".")
    module: Any = getattr(np, path[0]) if path else np
    function = getattr(module, last)

    def rounded_otherwise(*words: Any) -> Any:
        result = np.array(function(*words))
        result[-1] = np.nextafter(result[-1], np.inf)
        return result

    compute = fingerprint._fingerprint.__wrapped__  # without what it remembers
    before = compute()
    monkeypatch.setattr(module, last, rounded_otherwise)
    assert compute() != before == fingerprint.table()["fingerprint"]


def test_an_invalid_arithmetic_is_rejected() -> None:
    wrong: list[Any] = [{}, [], None, 3, {**OTHER, "numpy": 2}, {**OTHER, "core": "x" * 41}]
    for arithmetic in [*wrong, {**OTHER, "fingerprint": "\033[31m"}]:
        with pytest.raises((KeyError, TypeError, ValueError)):
            fingerprint.text(arithmetic if arithmetic is not None else 0)  # type: ignore[arg-type]
    assert fingerprint.text({**OTHER, "core": "compiled"}) == "numpy 1.0.0, arithmetic 0123456789ab (compiled)"


def test_a_summary_has_the_arithmetic_and_an_expectation_can_name_it(tmp_path: Path) -> None:
    wanted = {"of": "arithmetic.numpy", "equals": np.__version__}
    summary = written(tmp_path, inprocess.run(load("pair.toml", run__duration=0.1, expect=[wanted]), "pair"))
    assert summary["arithmetic"] == fingerprint.table()
    assert summary["arithmetic"]["core"] == "numpy"
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
        f"{state} was written with {THERE}; this is numpy 1.0.0, arithmetic ba9876543210: the digits would differ"
    )
    assert state.read_bytes() == kept


def test_a_sweep_is_not_continued_with_another_arithmetic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planned = design.plan(Path(PAIR), [], "0:2", [])
    with ledger.opened(tmp_path, planned):
        pass
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))
    with pytest.raises(FesError) as caught, ledger.opened(tmp_path, planned):
        pass
    assert str(caught.value) == (
        f"--out {tmp_path}: it holds a sweep of another arithmetic; "
        f'sweep.json has arithmetic = "{HERE}", and this is {THERE}'
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


def test_replay_and_compare_distinguish_another_processor_from_an_edited_log(
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
    assert caught.value.__notes__ == [f"recorded with {THERE}; executed with {HERE}"]
    assert "\n" not in str(caught.value)
    assert compare.compare(own, edited) == 1
    output = capsys.readouterr().out.splitlines()
    assert output[1:] == [f"A was recorded with {HERE}; B was recorded with {THERE}"]
    assert compare.compare(own, edited, json_=True) == 1
    assert json.loads(capsys.readouterr().out)["arithmetic"] == [fingerprint.table(), OTHER]


def test_a_summary_whose_arithmetic_is_not_that_of_its_log_is_named(tmp_path: Path) -> None:
    summary = recordings.record(tmp_path / "a.mcap", load("pair.toml", run__duration=0.1))
    recordings.rewrite(
        tmp_path / "a.mcap", tmp_path / "b.mcap", lambda *words: words[2], {**summary, "arithmetic": OTHER}
    )
    with pytest.raises(Mismatch, match=r"^summary: arithmetic is "):
        replay_command.rerun(log.load(tmp_path / "b.mcap"))
