"""fes run on data: processes and one loop have one digest, and broken data are one line before any process starts."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.commands import call, complaint
from tests.support.paths import PAIR

TRACE = "time,sender,receiver,decoded\n" + "".join(
    f"{0.1 * step:g},{a},{b},{(step + a) % 2}\n" for step in range(20) for a, b in ((0, 1), (1, 0))
)
WORDS = {
    "trace": ["--set", "channel.model=trace", "--set", "channel.trace=links.csv"],
    "table": ["--set", "channel.model=table", "--set", "channel.rows=[[40, 1], [80, 0.5]]"],
}


def summary(where: Path, *words: str) -> dict[str, Any]:
    """The summary of a run of two robots that count beacons."""
    done = call(
        where,
        "fes",
        "run",
        PAIR,
        "--set",
        "seeking.index=measured",
        "--duration",
        "2",
        "--headless",
        "--json",
        *words,
    )
    assert done.returncode == 0, done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


@pytest.mark.parametrize("model", WORDS)
def test_processes_and_one_loop_have_one_digest_on_data(tmp_path: Path, model: str) -> None:
    (tmp_path / "links.csv").write_text(TRACE, encoding="utf-8")
    processes, loop = (summary(tmp_path, *WORDS[model], *words) for words in ([], ["--backend", "inprocess"]))
    assert (processes["backend"], loop["backend"]) == ("processes", "inprocess")
    assert processes["digest"] == loop["digest"]
    assert (processes["optimal_separation"] is None) == (model == "trace")


def test_a_broken_trace_is_one_line_before_any_process_starts(tmp_path: Path) -> None:
    path = tmp_path / "links.csv"
    path.write_text(TRACE + "9,0,1,2\n", encoding="utf-8")
    done = call(tmp_path, "fes", "run", PAIR, *WORDS["trace"], "--headless")
    assert complaint(done, "fes") == (f"{PAIR}: channel.trace: {path}, line 42: decoded must be 0 or 1, got 2")
    assert not (tmp_path / "runs").exists()


def test_a_fit_is_printed_and_its_refusal_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "packets.csv"
    path.write_text("separation,decoded\n10,1\n20,0\n30,1\n40,0\n50,0\n", encoding="utf-8")
    done = call(tmp_path, "fes", "fit", "packets.csv", "--model", "logistic")
    assert (done.returncode, done.stderr) == (0, "")
    assert "[channel]" in done.stdout.splitlines()
    path.write_text("separation,decoded\n10,1\n20,1\n", encoding="utf-8")
    done = call(tmp_path, "fes", "fit", "packets.csv")
    assert complaint(done, "fes") == "packets.csv: all 2 packets decoded: a fit needs decoded and lost ones"
