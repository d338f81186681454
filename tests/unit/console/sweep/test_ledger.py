"""The ledger of a sweep: complete lines, each run once, one design per directory."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from console.sweep import design, ledger, work
from fes.errors import FesError
from fes.extension import registry
from tests.support.paths import PAIR


def test_a_line_cut_short_by_a_kill_is_dropped_and_rewritten(tmp_path: Path) -> None:
    planned = design.plan(Path(PAIR), [], "0:3", [])
    ended = [work.Done(run.key, {"ticks": run.seed}) for run in planned.runs]
    (tmp_path / f".{ledger.HEADER}").write_text("{")  # of a kill during the first write
    with ledger.opened(tmp_path, planned) as book:
        book.add(ended)
        book.add(ended)
    complete = (tmp_path / ledger.LINES).read_bytes()
    assert complete.count(b"\n") == 3
    (tmp_path / ledger.LINES).write_bytes(complete[:-7])
    with ledger.opened(tmp_path, planned) as book:
        assert list(book.done.values()) == ended[:2]
        book.add(ended)
    assert (tmp_path / ledger.LINES).read_bytes() == complete


@pytest.mark.parametrize(
    ("axes", "settings", "message"),
    [
        (["formation.rule=disk"], [], "other axes"),
        ([], ["run.duration=3"], "another scenario"),
    ],
)
def test_a_directory_of_another_sweep_is_not_changed(
    axes: list[str], settings: list[str], message: str, tmp_path: Path
) -> None:
    with ledger.opened(tmp_path, design.plan(Path(PAIR), [], "0:2", [])):
        pass
    with ledger.opened(tmp_path, design.plan(Path(PAIR), [], "0:9", [])):
        pass  # more seeds are the same sweep
    other = design.plan(Path(PAIR), axes, "0:2", settings)
    with pytest.raises(FesError, match=f"holds a sweep of {message}"), ledger.opened(tmp_path, other):
        pass


def test_a_directory_in_use_and_one_without_a_sweep_are_rejected(tmp_path: Path) -> None:
    planned = design.plan(Path(PAIR), [], "0:2", [])
    with ledger.opened(tmp_path, planned):
        with pytest.raises(FesError, match="another fes sweep is using it"), ledger.opened(tmp_path, planned):
            pass
        with (tmp_path / ledger.LINES).open("ab") as file:
            file.write(b"gibberish\n")
    with pytest.raises(FesError, match="line 1 is not a run"), ledger.opened(tmp_path, planned):
        pass
    (tmp_path / ledger.HEADER).unlink()
    with pytest.raises(FesError, match="not empty, and holds no sweep"), ledger.opened(tmp_path, planned):
        pass


METRIC = """
from fes.extension import NoParameters


class Constant:
    Parameters = NoParameters

    def __init__(self, parameters, context):
        pass

    def add(self, tick):
        pass

    def result(self):
        return {"value": VALUE}
"""


@pytest.fixture
def metric(tmp_path: Path) -> Iterator[Path]:
    """A file with a metric, and the scenario that has it: `lab.toml`."""
    path, source = list(sys.path), tmp_path / "swept_metric.py"
    source.write_text(METRIC.replace("VALUE", "1.0"))
    (tmp_path / "lab.toml").write_text(
        'schema = 1\n[run]\nduration = 0.1\n[robots]\ncount = 2\n[[metric]]\nuse = "swept_metric:Constant"\n'
    )
    registry.use(str(source))
    yield source
    registry.withdraw("swept_metric")
    sys.path[:] = path
    del sys.modules["swept_metric"]


def test_a_sweep_is_not_resumed_with_another_source_of_an_extension(metric: Path, tmp_path: Path) -> None:
    def planned(seeds: str) -> design.Design:
        registry.use(str(metric))
        return design.plan(tmp_path / "lab.toml", [], seeds, [])

    with ledger.opened(tmp_path / "out", planned("0:2")):
        pass
    with ledger.opened(tmp_path / "out", planned("0:3")):
        pass
    metric.write_text(METRIC.replace("VALUE", "2.0"))
    with (
        pytest.raises(FesError, match="holds a sweep of another source of its extensions"),
        ledger.opened(tmp_path / "out", planned("0:3")),
    ):
        pass


def test_a_worker_does_not_run_another_source_than_that_of_the_sweep(metric: Path, tmp_path: Path) -> None:
    planned = design.plan(tmp_path / "lab.toml", [], "0:1", [])
    (batch,) = work.batches("lab", planned.runs, 1)
    (done,) = work.carry_out(batch)
    assert done.scalars["metrics.Constant.value"] == 1.0
    metric.write_text(METRIC.replace("VALUE", "2.0"))
    with pytest.raises(FesError, match=r"^the sweep: the source of metric 'swept_metric:Constant' has changed: SHA"):
        work.carry_out(batch)
