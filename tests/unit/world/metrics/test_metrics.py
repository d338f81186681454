"""Errors, levels, connectivity and digest of a run, against hand-made series and the text of the contract."""

import math
import re
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from console.backends import inprocess
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.model.quantities import LEVELS
from fes.model.sensing import Telemetry
from tests.support import layouts, loop
from tests.support.results import Tick, contract_digest
from world.config.radio import RadioConfig
from world.metrics import link_errors
from world.metrics.link_errors import LinkErrors
from world.metrics.tick_truth import TickTruth
from world.simulation import channel, neighbor_list, truth
from world.simulation.truth import State, World

OPTIMUM = 68.0  # m
DT = 0.5  # s: ten seconds are twenty ticks
BOTH = [(0, 1), (1, 0)]


def add(
    errors: LinkErrors,
    where: Floats,
    links: Edges,
    estimates: Sequence[float],
    twists: Floats | None = None,
    open_contacts: bool = True,
) -> None:
    """Add one tick; the robots' ids are 0 to n - 1."""
    ids = np.arange(len(where))
    near = neighbor_list.measure(ids, where, layouts.REACH, None)
    held = np.zeros((len(where), 2)) if twists is None else twists
    telemetry = Telemetry(links, np.array(estimates), np.zeros((2, 0)), np.zeros((len(where), 0)))
    separation = link_errors.separations(where, *link_errors.ends(links))
    present, radio = np.ones(len(where), dtype=np.bool_), channel.quiet(near.edges)
    state = State(errors.ticks, where, where, RadioConfig(), near, radio, present, 0 * ids, int(open_contacts), 0)
    errors.add(TickTruth(state, held, telemetry, separation, separation, OPTIMUM, errors.ticks == 0))


def times(
    separations: Sequence[float] = (), estimates: Sequence[tuple[float, float]] = ()
) -> dict[str, float | None]:
    """time_to of two robots with these separation errors and pairs of estimate errors [m], tick by tick."""
    errors, links = LinkErrors(DT), layouts.edges([0, 1], BOTH)
    for error in separations:
        add(errors, layouts.poses([(0.0, 0.0), (OPTIMUM + error, 0.0)]), links, [OPTIMUM] * 2)
    for mine, theirs in estimates:
        add(errors, layouts.poses([(0.0, 0.0), (OPTIMUM, 0.0)]), links, [OPTIMUM + mine, OPTIMUM + theirs])
    return errors.times()


def test_the_digest_is_the_hash_over_ticks_and_robots_as_defined() -> None:
    rng = np.random.default_rng(3)
    ticks = [(layouts.scatter(rng, 4, 90.0), rng.normal(size=(4, 2))) for _ in range(20)]
    ticks[5] = (
        -0.0 * ticks[5][0],
        np.asfortranarray(ticks[5][1]),
    )  # signs of zero and memory order do not matter
    errors, nothing = LinkErrors(DT), layouts.edges(range(4), [])
    for poses, twists in ticks:
        add(errors, poses, nothing, [], twists)
    assert errors.digest.text() == contract_digest(ticks)
    assert errors.digest.text() != contract_digest(ticks[:-1])


def test_the_digest_of_a_run_is_that_of_its_true_poses_and_twists(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks: list[Tick] = []
    step = truth.step

    def recorded(world: World, state: State, twists: Floats) -> State:
        ticks.append((state.poses.copy(), twists.copy()))
        return step(world, state, twists)

    monkeypatch.setattr(truth, "step", recorded)
    result = inprocess.run(loop.load("paper.toml", run__duration=1), "paper")
    assert len(ticks) == 50
    assert result["digest"] == contract_digest(ticks)


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ([2.0] * 50, None),
        ([0.5] * 50, 0.0),
        ([2.0] * 3 + [0.5] * 40, 1.5),
        ([2.0] * 3 + [-0.5] * 40, 1.5),  # too near is an error, like too far
        ([2.0] * 3 + [0.5] * 40 + [5.0] * 30, 1.5),  # after ten seconds the level may be lost again
        ([0.5] * 15 + [2.0] + [0.5] * 40, 8.0),  # an interrupted hold starts again
        ([0.5] * 15 + [2.0] * 30, None),
        ([0.5] * 21 + [2.0] * 30, 0.0),
        ([2.0] * 2 + [0.5] * 5, 1.0),  # a run shorter than ten seconds: to its end
        ([0.5] * 6 + [2.0], None),
        ([math.inf] * 2 + [0.5] * 40, 1.0),
    ],
)
def test_a_level_is_reached_at_the_start_of_the_ten_seconds_for_which_it_holds(
    errors: list[float], expected: float | None
) -> None:
    result = times(separations=errors)
    assert result["separation_1m"] == expected
    assert result["separation_0_1m"] is None
    assert times(separations=[error / 10.0 for error in errors])["separation_0_1m"] == expected
    assert times(estimates=[(0.0, error) for error in errors])["estimate_1m"] == expected
    assert times(estimates=[(error / 10.0, 0.0) for error in errors])["estimate_0_1m"] == expected
    assert times(estimates=[(2.0, 2.0 + error) for error in errors])["disagreement_1m"] == expected


@given(series=st.lists(st.integers(1, 45).map(lambda n: "." * n) | st.just("x"), max_size=8).map("".join))
def test_the_time_to_a_level_is_that_of_the_first_hold_that_lasts_long_enough(series: str) -> None:
    series += "x" * 25  # no hold at the end, and no short run
    hold = re.search(r"\.{21}", series)
    expected = None if hold is None else hold.start() * DT
    # 20 ticks that hold span 9.5 s or 10 s, by the way of counting: not tested
    if not re.search(r"(?<!\.)\.{20}(?!\.)", series):
        assert times([3.0 if mark == "x" else 0.2 for mark in series])["separation_1m"] == expected


@pytest.mark.parametrize("one_sided", [(1, 2), (2, 1)])
def test_errors_and_disagreement_of_three_robots_are_those_computed_by_hand(
    one_sided: tuple[int, int],
) -> None:
    where = layouts.poses([(0.0, 0.0), (60.0, 0.0), (60.0, 32.0)])  # 0-1: 60 m, 1-2: 32 m, 0-2: 68 m
    estimates = {(0, 1): 67.0, (1, 0): 69.5, (0, 2): 68.25, (2, 0): 67.0, one_sided: 75.0}
    links = layouts.edges(range(3), estimates)
    errors = LinkErrors(DT)
    add(errors, where, links, [estimates[pair] for pair in sorted(estimates)])
    assert errors.errors == {
        "disagreement": 2.5 + 1.25,  # a link that one robot uses has no disagreement
        "estimate_error": 7.0,  # it has an estimate
        "separation_error": 36.0,  # it has a separation
        "estimate": 69.35,
    }


def test_without_links_there_is_no_error_and_no_level_is_reached() -> None:
    errors = LinkErrors(DT)
    for _ in range(30):
        add(errors, layouts.poses([(0.0, 0.0), (OPTIMUM, 0.0)]), layouts.edges([0, 1], []), [])
    assert all(math.isnan(error) for error in errors.errors.values())
    assert set(errors.times().values()) == {None}
    assert sorted(errors.times()) == sorted(LEVELS)


@pytest.mark.parametrize(
    ("story", "always"),
    [("---oooo", True), ("o--oooo", True), ("---oooox", False), ("---xooo", False), ("---oox---", False)],
)
def test_links_count_as_connected_from_the_first_tick_with_open_contacts(story: str, always: bool) -> None:
    # `-`: no open contact, no links; `o`: open contacts, all robots linked, on one side; `x`: robot 2 is alone
    where, errors = layouts.poses([(0.0, 0.0), (60.0, 0.0), (120.0, 0.0)]), LinkErrors(DT)
    for mark in story:
        pairs = {"-": [], "o": [(0, 1), (2, 1)], "x": BOTH}[mark]
        links = layouts.edges(range(3), pairs)
        add(errors, where, links, [OPTIMUM] * len(pairs), open_contacts=mark != "-")
    assert errors.links_always is always
    assert errors.disk_always


def test_the_disk_graph_is_always_connected_only_if_it_is_at_every_tick() -> None:
    near, far = layouts.poses([(0.0, 0.0), (149.0, 0.0)]), layouts.poses([(0.0, 0.0), (151.0, 0.0)])
    errors, nothing = LinkErrors(DT), layouts.edges([0, 1], [])
    seen = []
    for where in (near, near, far, near):
        add(errors, where, nothing, [])
        seen.append((errors.disk_now, errors.disk_always))
    assert seen == [(True, True), (True, True), (False, False), (True, False)]
