"""Robots that all start within range of each other: the same links, in memory proportional to their contacts."""

import math
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from agents.laws import neighbor_rules
from agents.laws.neighbor_rules import Witnesses
from agents.runtime.reception import Receiver
from bench.size.crowd import dense
from console import cli
from console.backends import inprocess
from fes.arithmetic import draws
from fes.arrays.types import Bools, Floats
from fes.errors import ScenarioError
from fes.model.contacts import Contacts
from fes.model.sensing import DECODED, LOST, Observations
from fes.system import memory
from tests.support import laws, layouts
from tests.support.paths import CONFIGS
from world.config import scenario
from world.execution.run import Run
from world.simulation import crowd, neighbor_list, truth

LAYOUTS: dict[str, Callable[[np.random.Generator, int], Floats]] = {
    "scattered": lambda rng, n: layouts.scatter(rng, n, 120.0),
    "sparse": lambda rng, n: layouts.scatter(rng, n, 900.0),
    "lattice": lambda rng, n: np.column_stack([rng.integers(0, 6, (n, 2)) * 10.0, np.zeros(n)]),
    "line": lambda rng, n: np.column_stack([np.sort(rng.uniform(0.0, 140.0, n)), np.zeros(n), np.zeros(n)]),
    "one place": lambda rng, n: np.full((n, 3), 7.0),
    "circle": lambda rng, n: layouts.poses((50.0 * math.cos(a), 50.0 * math.sin(a)) for a in range(n)),
}


def all_triples(known: Contacts) -> Bools:
    """The relative neighborhood as it was found before blocks: every (pair, third robot) at once [m]."""
    edges, reach = known.edges, np.where(known.known, known.separation, np.inf)
    counts = edges.counts[edges.rows]
    first = (np.cumsum(edges.counts) - edges.counts)[edges.rows]
    offset = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
    pair, witness = np.repeat(np.arange(len(edges)), counts), np.repeat(first, counts) + offset
    dx, dy = known.x[witness] - known.x[pair], known.y[witness] - known.y[pair]
    excluded = np.maximum(reach[witness], np.sqrt(dx * dx + dy * dy)) < known.separation[pair]
    left: Bools = known.known & (np.bincount(pair, excluded, minlength=len(edges)) == 0.0)
    return left


def heard_again(known: Contacts, where: Floats, decoded: Bools, tick: int) -> Contacts:
    """The contacts a tick later: robots at `where` [n, 3], beacons `decoded` [m]."""
    codes = np.where(decoded, DECODED, LOST).astype(np.uint8)
    beacons = layouts.silent_beacons(tick - 1, np.arange(len(where)), where)
    return layouts.heard(known, Receiver(), Observations(tick, where, known.edges, codes), where, beacons, timeout=2)


@pytest.mark.parametrize("layout", sorted(LAYOUTS))
@pytest.mark.parametrize(("block", "nearest"), [(50, 4), (1000, 4), (2**16, 16), (10**6, 0)])
def test_links_found_in_blocks_are_those_of_all_triples_at_once(
    monkeypatch: pytest.MonkeyPatch, layout: str, block: int, nearest: int
) -> None:
    """To the bit, and while robots move, are not heard, and witnesses are remembered."""
    monkeypatch.setattr(neighbor_rules, "FEW", 0)
    monkeypatch.setattr(neighbor_rules, "BLOCK", block)
    monkeypatch.setattr(neighbor_rules, "NEAREST", nearest)
    rng = np.random.default_rng(5)
    where = LAYOUTS[layout](rng, 60)
    known = layouts.hear(where, range(60))
    witnesses = Witnesses(known.edges)
    for tick in range(2, 8):
        result = neighbor_rules.relative_neighborhood(known, witnesses)
        assert result.tolist() == all_triples(known).tolist()
        where = where + np.column_stack([rng.normal(0.0, 2.0, (60, 2)), np.zeros(60)])
        known = heard_again(known, where, rng.random(len(known.edges)) < 0.7, tick)


@pytest.mark.parametrize("block", [20, 10**6])
@pytest.mark.parametrize("layout", sorted(LAYOUTS))
def test_pairs_found_in_blocks_are_those_of_a_search_of_all_pairs(
    monkeypatch: pytest.MonkeyPatch, layout: str, block: int
) -> None:
    monkeypatch.setattr(neighbor_list, "SMALL", 1)
    monkeypatch.setattr(neighbor_list, "BLOCK", block)
    where = LAYOUTS[layout](np.random.default_rng(6), 70) - np.array([60.0, 60.0, 0.0])
    edges = neighbor_list.measure(np.arange(70), where, 100.0, None).edges
    expected = layouts.pairs_of(layouts.in_range(where, range(70), 100.0))
    assert layouts.pairs_of(edges) == expected
    assert len(edges) == len(expected)
    assert neighbor_list.count(where, 100.0, 10**6) == len(expected)


@pytest.mark.slow
@pytest.mark.parametrize("rule", laws.RULES)
def test_a_crowd_takes_memory_in_proportion_to_its_contacts(rule: str) -> None:
    """For any number of contacts: their triples with third robots are 80 and 160 times as many."""
    for robots in (80, 160):
        configured, numbers = dense(robots, rule), 128 * 8
        tracemalloc.start()
        try:
            pairs = [len(tick.state.radio.edges) for tick in inprocess.ticks(configured)]
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
        assert pairs == [robots * (robots - 1)] * len(pairs)
        # 128 of the radio's numbers, 140 arrays over contacts and links, and some buffers of a fixed size
        assert peak < pairs[0] * (numbers + 140 * 8) + 10 * 8 * neighbor_rules.BLOCK


def test_the_random_numbers_of_the_radio_are_drawn_in_place() -> None:
    senders = np.arange(2000)
    draws.uniform_ticks(draws.key(1, "channel"), 0, 128, senders[:2], senders[:2])
    tracemalloc.start()
    try:
        draws.uniform_ticks(draws.key(1, "channel"), 0, 128, senders, senders)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1.3 * 128 * 8 * len(senders)


def test_a_crowd_that_does_not_fit_into_memory_is_rejected_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available", lambda: 2_000_000_000)
    expected = (
        "robots: the memory of the 8,997,000 contacts within 150 m must be at most the 2.0 GB that are free, "
        "got 9.0 GB: use fewer robots, or a larger spacing"
    )
    with pytest.raises(ScenarioError) as refused:
        truth.start(truth.create(dense(3000, "disk")))
    assert str(refused.value) == expected


def test_many_robots_that_are_not_in_range_of_each_other_are_not_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    spread = dense(3000, "disk")
    robots = spread.robots.model_copy(update={"spacing": 78.0})
    monkeypatch.setattr(memory, "available", lambda: 40_000_000)  # 8 contacts each are 24 MB
    crowd.check(spread.model_copy(update={"robots": robots}))


def test_a_range_that_turns_a_team_into_a_crowd_is_rejected_whether_scheduled_or_set(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fields = {"robots.count": 100, "run.duration": 1.0}
    monkeypatch.setattr(memory, "available", lambda: 2_000_000)  # 684 contacts at the start
    calm = scenario.load(CONFIGS / "hundred.toml", fields)
    run = Run(calm)
    with pytest.raises(
        ScenarioError, match=r"^robots: the memory of the 9,900 contacts within 1e\+06 m must be at most"
    ):
        run.change("channel.communication_range", 1e6)
    assert run.state.channel == calm.channel
    run.change("channel.communication_range", 160.0)
    later = {"at": 0.5, "set": {"channel.communication_range": 1e6}}
    with pytest.raises(ScenarioError, match=r"^robots: the memory of the 9,900 contacts"):
        crowd.check(scenario.load(CONFIGS / "hundred.toml", {**fields, "event": [later]}))


def test_fes_run_rejects_a_crowd_before_it_makes_a_run_directory(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(memory, "available", lambda: 1_000_000)
    arguments = ["run", str(CONFIGS / "hundred.toml"), "--set", "robots.spacing=1.0", "--out", str(tmp_path / "out")]
    monkeypatch.setattr(sys, "argv", ["fes", *arguments])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 1
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_free_memory_is_the_least_of_machine_container_and_limit(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "meminfo").write_text("MemTotal: 9000 kB\nMemAvailable:    5000 kB\n")
    monkeypatch.setattr(memory, "MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory, "CGROUP", tmp_path)
    assert memory.available() == 5_120_000
    (tmp_path / "memory.max").write_text("max\n")
    (tmp_path / "memory.current").write_text("1000000\n")
    assert memory.available() == 5_120_000
    (tmp_path / "memory.max").write_text("4000000\n")
    assert memory.available() == 3_000_000
    (tmp_path / "memory.stat").write_text("anon 100000\ninactive_file 500000\nactive_file 400000\n")
    assert memory.available() == 3_900_000
    monkeypatch.setattr(memory, "_limit", lambda: -5)
    assert memory.available() == 0
