"""A sweep on a Dask cluster of real worker processes, one of which is killed: the same results."""

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import LocalCluster

from console.sweep import cluster, design, work
from console.terminal import counting
from fes.errors import FesError
from fes.system import fingerprint
from tests.support.arithmetics import OTHER
from tests.support.commands import PROGRAMS, call, complaint, vacant
from tests.support.paths import PAIR
from tests.support.sweeps import RUNS, finished, until_some_are_done

LONG = ["sweep", PAIR, "--seeds", "0:120", "--set", "run.duration=4"]


@pytest.fixture(scope="module")
def dask() -> Iterator[LocalCluster]:
    """Two workers of one thread each, behind nannies that replace them if they die."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as opened:
        yield opened


def test_a_worker_killed_midway_loses_no_run_and_repeats_none(dask: LocalCluster, tmp_path: Path) -> None:
    words = [str(PROGRAMS / "fes"), *LONG, "--out", "out", "--scheduler", dask.scheduler_address]
    sweep = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until_some_are_done(tmp_path / "out", sweep)
    assert len(finished(tmp_path / "out")) < RUNS
    os.kill(dask.workers[0].pid, signal.SIGKILL)
    output, complained = sweep.communicate(timeout=60)
    assert (sweep.returncode, complained) == (0, "")
    assert "out/table.csv" in output
    assert len(finished(tmp_path / "out")) == len(set(finished(tmp_path / "out"))) == RUNS

    local = call(tmp_path, "fes", *LONG, "--out", "here")
    assert local.returncode == 0
    for name in ("table.csv", "cells.csv"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


def test_workers_report_ticks_before_their_batch_has_ended(
    dask: LocalCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "PERIOD", 0.001)
    planned = design.plan(Path(PAIR), [], "0:4", ["run.duration=40"])
    ticks, results = [0], []
    with cluster.connected(dask.scheduler_address) as workers:
        for done in workers.carry_out(work.batches("pair", planned.runs, 2), ticks.append):
            results.append((ticks[-1], len(done)))
    assert [count for _, count in results] == [2, 2]
    assert results[0][0] > 0  # known before the first result
    assert ticks == sorted(ticks)
    assert ticks[-1] == 4 * 2000


def test_a_worker_with_another_version_of_fes_is_rejected(
    dask: LocalCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "version", lambda: "9.9")
    planned = design.plan(Path(PAIR), [], "0:1", ["run.duration=1"])
    with cluster.connected(dask.scheduler_address) as workers:
        assert workers.count == 2
        with pytest.raises(FesError, match=r"a Dask worker has fes .*, and the sweep is of fes 9\.9"):
            list(workers.carry_out(work.batches("pair", planned.runs, 2), counting.ignore))


def test_a_worker_with_another_arithmetic_is_rejected(dask: LocalCluster, monkeypatch: pytest.MonkeyPatch) -> None:
    own = fingerprint.text()
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))  # of this side only
    planned = design.plan(Path(PAIR), [], "0:1", ["run.duration=1"])
    wanted = rf"^a Dask worker has {own}, and the sweep is of {fingerprint.text()}$"
    with cluster.connected(dask.scheduler_address) as workers, pytest.raises(FesError, match=wanted):
        list(workers.carry_out(work.batches("pair", planned.runs, 2), counting.ignore))


def test_a_scheduler_that_does_not_answer_is_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address = vacant().replace("tcp/", "tcp://")
    monkeypatch.setattr(cluster, "PATIENCE", 0.3)
    with pytest.raises(FesError, match=f"no Dask scheduler answers at {address}"), cluster.connected(address):
        pass
    line = complaint(call(tmp_path, "fes", "sweep", PAIR, "--seeds", "0:1", "--scheduler", f"{address}0000"), "fes")
    assert line.startswith("--scheduler expects an address")
    assert list(tmp_path.iterdir()) == []


def test_a_cluster_without_workers_is_reported_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 1.0)
    with (
        LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0") as empty,
        pytest.raises(FesError, match="has no workers"),
        cluster.connected(empty.scheduler_address),
    ):
        pass
