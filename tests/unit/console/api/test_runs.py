"""fes.run and fes.read: the arrays of a run are those of its log and of its messages."""

import hashlib
import math
import sys
import threading
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import fes
from console.api import background
from fes.errors import FesError
from fes.extension import registry
from fes.protocol import messages
from fes.recording import reader
from fes.recording.ticks import LoggedTick
from tests.support.example_metric import Count
from tests.support.loop import load
from tests.support.python_runs import arrays
from world.config import scenario


def logged(directory: Path) -> list[LoggedTick]:
    return list(reader.load(directory, scenario.parse).ticks())


@pytest.mark.parametrize(
    ("name", "duration"),
    [("paper", 2.0), ("measured", 2.0), ("faults/death", 20.0), ("faults/delay", 12.0), ("faults/jam", 12.0)],
)
@pytest.mark.filterwarnings("ignore:event at")  # events after the end of these short runs
@pytest.mark.filterwarnings("ignore:the channel is set")
def test_the_arrays_of_a_run_and_of_its_log_are_equal_to_the_bit(name: str, duration: float, tmp_path: Path) -> None:
    live = fes.run(name, duration=duration, out=tmp_path / "out")
    read = fes.read(tmp_path / "out")
    assert arrays(read) == arrays(live)
    assert (read.summary, read.scenario, read.directory) == (live.summary, live.scenario, live.directory)
    assert arrays(fes.run(name, duration=duration)) == arrays(live)  # nothing depends on the recorder
    assert arrays(fes.read(tmp_path / "out" / "run.mcap")) == arrays(live)


def test_the_digest_is_that_of_the_arrays() -> None:
    run = fes.run("paper", seed=5, duration=1.0)
    digest = hashlib.sha256()
    for tick in range(50):
        rows = np.concatenate([run.poses[tick], run.twists[tick]], axis=1)
        digest.update(np.array(tick, "<i8").tobytes() + rows.astype("<f8").tobytes())
    assert run.digest == digest.hexdigest()
    assert (run.scenario.run.seed, run.summary["seed"]) == (5, 5)
    assert run.time.tolist() == [0.02 * tick for tick in range(50)]


def test_every_row_of_the_links_is_that_of_the_messages(tmp_path: Path) -> None:
    run = fes.run("paper", duration=1.0, out=tmp_path / "out")
    channel, expected = run.scenario.channel, []
    before: dict[tuple[int, int], float] = {}
    for tick in logged(tmp_path / "out"):
        sensed = [messages.decode_observation(payload) for payload in tick.payloads.observations]
        separations = {
            (a.robot, b.robot): math.hypot(a.pose[0] - b.pose[0], a.pose[1] - b.pose[1])
            for a in sensed
            for b in sensed
        }
        for payload in tick.payloads.commands:
            command = messages.decode_command(payload)
            observation = sensed[command.robot]
            reception = dict(zip(observation.in_range.tolist(), observation.reception.tolist(), strict=True))
            for peer, estimate in zip(command.links.tolist(), command.estimates.tolist(), strict=True):
                pair = command.robot, peer
                noise = (2.0**channel.spectral_efficiency - 1.0) / channel.reference_snr
                outage = 1.0 - math.exp(-noise * before[pair] ** channel.path_loss_exponent)
                expected.append((tick.number, *pair, separations[pair], estimate, outage, reception[peer] == 2))
        before = separations
    rows = list(zip(*(column.tolist() for column in vars(run.links).values()), strict=True))
    assert len(rows) == len(expected) == len(run.links) > 1000
    for row, true in zip(rows, expected, strict=True):
        assert row[:3] + row[4:5] + row[6:] == true[:3] + true[4:5] + true[6:]
        assert row[3] == pytest.approx(true[3], rel=1e-14)  # rounding of two square roots
        assert row[5] == pytest.approx(true[5], rel=1e-12)  # the power amplifies that rounding threefold


def test_a_robot_without_links_has_no_rows() -> None:
    run = fes.run("pair", duration=0.2, overrides={"channel.communication_range": 1.0})
    assert len(run.links) == 0
    assert run.links.separation.dtype == run.links.outage.dtype == np.float64


def test_a_run_takes_the_memory_that_its_docstring_states() -> None:
    run = fes.run("paper", duration=0.52)
    assert run.time.nbytes + run.poses.nbytes + run.twists.nbytes == 26 * (8 + 40 * 10)
    assert sum(column.nbytes for column in vars(run.links).values()) == 49 * len(run.links)
    for column in (run.poses, run.twists, *vars(run.links).values()):
        assert column.base is None  # not a view of a larger array


def test_a_scenario_a_name_and_a_path_are_the_same_run(tmp_path: Path) -> None:
    own = load("pair.toml", run__seed=3, run__duration=0.4)
    by_name = fes.run("pair", seed=3, duration=0.4)
    by_object = fes.run(fes.load("pair"), 3, overrides={"run": {"duration": np.float64(0.4)}}, name="mine")
    assert by_name.scenario == by_object.scenario == own
    assert arrays(by_name) == arrays(by_object) == arrays(fes.run(own))
    assert (by_name.summary["scenario"], by_object.summary["scenario"]) == ("pair", "mine")


def test_progress_is_reported_in_the_thread_of_the_caller_up_to_the_end() -> None:
    seen: list[tuple[int, int, bool]] = []

    def show(done: int, total: int) -> None:
        seen.append((done, total, threading.current_thread() is threading.main_thread()))

    fes.run("pair", duration=4.0, rtf=20.0, progress=show)
    assert seen[-1] == (200, 200, True)
    assert [done for done, _, _ in seen] == sorted(done for done, _, _ in seen)
    assert len(seen) > 1


def threads() -> list[str]:
    return [thread.name for thread in threading.enumerate()]


def test_an_interrupt_ends_the_run_at_a_tick_and_its_directory_holds_the_results_so_far(tmp_path: Path) -> None:
    whole, before = fes.run("pair", duration=4.0), threads()

    def interrupt(done: int, total: int) -> None:
        if done > 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as interrupted:
        fes.run("pair", duration=4.0, rtf=0.5, out=tmp_path / "out", progress=interrupt)
    assert threads() == before
    assert interrupted.value.__notes__ == [f"interrupted; the results so far are in {tmp_path / 'out'}"]
    part = fes.read(tmp_path / "out")
    assert 3 < len(part.time) < 200
    assert part.poses.tobytes() == whole.poses[: len(part.time)].tobytes()


def test_an_error_of_the_progress_function_stops_the_run_and_is_raised(tmp_path: Path) -> None:
    def fail(done: int, total: int) -> None:
        raise ZeroDivisionError

    before = threads()
    with pytest.raises(ZeroDivisionError):
        fes.run("pair", duration=1000.0, rtf=1e-6, progress=fail)  # a tick takes hours
    assert threads() == before
    assert background.THREAD not in before


def test_a_log_without_an_end_gives_its_ticks_a_summary_and_a_warning(tmp_path: Path) -> None:
    whole = fes.run("pair", duration=4.0, out=tmp_path / "out")
    path = tmp_path / "out" / "run.mcap"
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: -len(b"the magic bytes")])
    with pytest.warns(UserWarning, match="has no end, its run was killed or the file was cut: 200 of 200 ticks"):
        read = fes.read(cut)
    assert arrays(read) == arrays(whole)
    assert read.digest == whole.digest


def test_a_remark_on_the_scenario_is_a_warning_at_the_line_of_the_caller() -> None:
    with pytest.warns(UserWarning, match="run.duration 0.11 s is not a multiple") as remarks:
        fes.run("pair", duration=0.11)
    assert [Path(remark.filename) for remark in remarks] == [Path(__file__)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": "papers"}, "papers: No such file, .*the nearest is 'paper'"),
        ({"scenario": 3}, "scenario: expects a Scenario, a name or a path, got int"),
        ({"backend": "threads"}, "backend: expects 'inprocess' or 'processes', got 'threads'"),
        ({"rtf": 0.0}, "rtf: expects a number that is at least 1e-06, or None, got 0.0"),
        ({"agents_per_process": 0}, "agents_per_process: expects at least 1, got 0"),
        ({"seed": -1}, "run.seed: must be at least 0|run.seed: .*-1"),
        ({"overrides": {"run.sed": 1}}, "unknown field 'run.sed'; did you mean 'run.seed'?"),
        ({"overrides": {"run.seed.x": 1}}, "overrides: 'run.seed.x' goes through 'seed', which is not a table"),
        ({"overrides": {3: 1}}, "overrides: expects names of fields, got 3"),
        ({"overrides": ["run.seed=3"]}, "overrides: expects a dict, got list"),
        ({"overrides": {"run.seed": 2**70}}, "overrides: 'run.seed' has an integer of 71 bits"),
        ({"overrides": {"run.clock": "live"}}, "run.clock: 'live' needs processes"),
    ],
)
def test_an_invalid_argument_is_an_error_of_one_line_in_the_words_of_python(
    arguments: dict[str, object], message: str
) -> None:
    with pytest.raises(FesError, match=message) as refused:
        fes.run(**{"scenario": "pair", **arguments})  # type: ignore[arg-type]
    assert "\n" not in str(refused.value)
    assert "--" not in str(refused.value).replace("fes run --help", "")


def test_a_directory_that_is_not_empty_and_a_missing_log_are_errors(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FesError, match=r"^out .*: the directory is not empty"):
        fes.run("pair", out=tmp_path)
    with pytest.raises(FesError, match=r"has no run\.mcap: the run was not recorded"):
        fes.read(tmp_path)
    with pytest.raises(FesError, match="cannot be read: No such file or directory"):
        fes.read(tmp_path / "absent")


def test_a_class_of_the_notebook_itself_is_refused_before_other_processes_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    notebook = ModuleType("__main__")
    notebook.Count = Count  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "__main__", notebook)
    given: dict[str, Any] = {"overrides": {"run.duration": 0.1, "metric": [{"use": "__main__:Count"}]}}
    try:
        assert fes.run("pair", use="__main__", **given).summary["metrics"]["Count"]["ticks"] == 5.0
        with pytest.raises(FesError, match=r"^metric '__main__:Count': no other process can import it"):
            fes.run("pair", backend="processes", out=tmp_path / "run", **given)
        with pytest.raises(FesError, match=r"^metric '__main__:Count': no other process can import it"):
            fes.sweep("pair", seeds=[0], out=tmp_path / "sweep", **given)
    finally:
        registry.withdraw("__main__")
    assert not list(tmp_path.iterdir())
