"""JSON without NaN and Infinity: none is written anywhere, and none is accepted from a file."""

import ast
import csv
import json
import math
from pathlib import Path
from typing import Any

import pytest
from pyarrow import parquet

from console.backends import inprocess, processes
from console.dashboard import summary as shown
from console.replay import log
from console.sweep import ledger, table, work
from console.sweep.table import Format
from fes.errors import FesError, MessageError
from fes.protocol import channel_change, wire
from fes.protocol.channel_change import ParameterChange
from fes.system import strict_json
from tests.support import recordings
from tests.support.commands import call
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.source import PACKAGES, modules
from world.metrics import summary

BAD = (math.nan, math.inf, -math.inf)
WORDS = ("NaN", "Infinity", "-Infinity", "1e999", "-1e999")


def strictly(text: str | bytes) -> Any:
    """The value for a strict reader of JSON."""

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    return json.loads(text, parse_constant=refuse)


def filled(value: Any, bad: float) -> Any:
    """A summary in which every float is not finite."""
    if isinstance(value, float):
        return bad
    if isinstance(value, dict):
        return {key: filled(inner, bad) for key, inner in value.items()}
    return [filled(inner, bad) for inner in value] if isinstance(value, list) else value


def test_only_one_module_of_the_product_touches_the_json_library() -> None:
    users = set()
    for name, path in modules(*PACKAGES).items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            imported = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                imported = [node.module or ""]
            users |= {name} if {"json", "simplejson", "orjson", "ujson"} & set(imported) else set()
    assert users == {"fes.system.strict_json"}


@pytest.mark.parametrize("bad", BAD)
def test_numbers_that_are_not_finite_become_null_at_any_depth(bad: float) -> None:
    value = {"a": bad, "b": [1.5, (bad, {"c": bad})], "d": True, "e": "NaN"}
    assert strictly(strict_json.dumps(value)) == {"a": None, "b": [1.5, [None, {"c": None}]], "d": True, "e": "NaN"}
    with pytest.raises(ValueError, match="JSON"):
        strict_json.dumps(value, refuse=True)


@pytest.mark.parametrize("word", WORDS)
def test_no_reader_accepts_a_number_that_is_not_finite(word: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="is not a number of JSON"):
        strict_json.loads(f'{{"a": [{word}]}}')
    (tmp_path / "summary.json").write_text(f'{{"ticks": {word}}}')
    with pytest.raises(FesError, match="has no summary"):
        processes.read_summary(tmp_path)
    with pytest.raises(MessageError, match="expects a value as JSON"):
        channel_change.decode_change(wire.pack("channel.reference_snr", word))
    (tmp_path / ledger.LINES).write_text(f'{{"key": "k", "scalars": {{"a": {word}}}, "error": null}}\n')
    with (tmp_path / ledger.LINES).open("a+b") as file, pytest.raises(FesError, match="line 1 is not a run"):
        ledger._read(file, tmp_path / ledger.LINES)


def test_a_log_whose_summary_is_not_json_is_rejected_in_one_line(tmp_path: Path) -> None:
    run_summary = recordings.record(tmp_path / "run.mcap", load("pair.toml", run__duration=0.2))
    bad = {**run_summary, "separation_error_max": math.inf}
    recordings.rewrite(tmp_path / "run.mcap", tmp_path / "bad.mcap", lambda topic, tick, data: data, bad)
    with pytest.raises(FesError, match="cannot be read: Infinity is not a number of JSON") as caught:
        log.load(tmp_path / "bad.mcap")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("bad", BAD)
def test_a_value_that_is_not_finite_cannot_be_set(bad: float) -> None:
    with pytest.raises(MessageError, match="expects finite numbers"):
        channel_change.encode_change(ParameterChange("channel.reference_snr", bad))


@pytest.mark.parametrize("bad", BAD)
def test_a_summary_of_numbers_that_are_not_finite_is_strict_json_and_can_be_printed(
    bad: float, tmp_path: Path
) -> None:
    expected = [{"of": "separation_error_max", "below": 1.0}]
    true = inprocess.run(load("pair.toml", run__duration=1.0, expect=expected), "pair")
    result = {**filled(true, bad), "simulated_s": true["simulated_s"], "wall_s": true["wall_s"]}  # bounded, measured
    summary.write(tmp_path, result)
    read = strictly((tmp_path / "summary.json").read_text())
    assert read["separation_error_max"] is None
    assert read["edges"][0][2:] == [None] * 3
    assert summary.lines(read)
    shown.render(read, verbose=True)
    assert strictly(strict_json.dumps(work.scalars(result)))["separation_error_max"] is None


def test_a_run_reports_an_error_that_is_not_finite_as_null(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(summary, "_rms", lambda errors: math.inf)
    run_summary = recordings.record(tmp_path / "run.mcap", load("pair.toml", run__duration=0.2))
    assert run_summary["separation_error_rms"] is None
    assert log.load(tmp_path / "run.mcap").summary == run_summary


@pytest.mark.parametrize("form", list(Format))
def test_a_table_shows_a_number_that_is_not_finite_as_missing(form: Format, tmp_path: Path) -> None:
    rows: list[table.Row] = [{"time": value, "error": None} for value in (1.5, *BAD, None)]
    path = table.write(tmp_path, "table", rows, form)
    if form is Format.PARQUET:
        assert parquet.read_table(path)["time"].to_pylist() == [1.5] + [None] * 4
    else:
        with path.open(newline="") as file:
            assert [row["time"] for row in csv.DictReader(file)] == ["1.5", "", "", "", ""]


def test_files_of_a_sweep_are_strict_json_even_without_an_outcome(tmp_path: Path) -> None:
    short = ["--set", "run.duration=0.2", "--axis", "formation.rule=disk,two_nearest", "--jobs", "1", "--out", "out"]
    done = call(tmp_path, "fes", "sweep", PAIR, "--seeds", "0:2", *short)
    assert done.returncode == 0, done.stderr
    strictly((tmp_path / "out" / "sweep.json").read_text())
    for line in (tmp_path / "out" / "runs.jsonl").read_text().splitlines():
        strictly(line)
    for name in ("table", "cells", "differences"):
        text = (tmp_path / "out" / f"{name}.csv").read_text()
        assert not {"nan", "inf", "-inf"} & {field for line in text.splitlines() for field in line.split(",")}
