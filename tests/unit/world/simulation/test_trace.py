"""The channel `trace`: the value of a pair at a time, against the plain reading of its rows."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fes.errors import FesError
from fes.extension.context import SeededDraws, WorldContext
from fes.model.config import ObjectiveConfig
from fes.model.sensing import DECODED, LOST
from tests.support.radios import ledger, stand, started
from world.config.radio import RadioConfig
from world.config.scenario import Scenario, parse
from world.simulation import truth
from world.simulation.trace import TraceChannel

DT = 0.02
HEADER = "time,sender,receiver,probability\n"

Row = tuple[float, int, int, float]


def settings(folder: Path, rows: list[Row], between: str = "held") -> dict[str, Any]:
    """The channel of these rows."""
    path = folder / "links.csv"
    path.write_text(HEADER + "".join(f"{','.join(map(str, row))}\n" for row in rows), encoding="utf-8")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return {"model": "trace", "trace": str(path), "trace_sha256": digest, "trace_between": between}


def channel(folder: Path, rows: list[Row], between: str = "held", robots: int = 20, dt: float = DT) -> TraceChannel:
    config = RadioConfig.model_validate(settings(folder, rows, between))
    return TraceChannel(config, WorldContext(dt, robots, ObjectiveConfig(), SeededDraws(1)))


def team(positions: list[tuple[float, float]], event: tuple[dict[str, Any], ...] = (), **channel: Any) -> Scenario:
    """Robots that count beacons: a trace cannot be told."""
    tables = {"schema": 1, "run": {"seed": 4}, "robots": {"poses": [[x, y, 0.0] for x, y in positions]}}
    return parse({**tables, "seeking": {"index": "measured"}, "channel": channel, "event": list(event)}, "here")


def at(model: TraceChannel, time: float, *pairs: tuple[int, int]) -> list[float]:
    """The probability of each (sender, receiver)."""
    senders, receivers = np.array(pairs).T
    values: list[float] = model.pair_probability(time, senders, receivers, np.full(len(pairs), 50.0)).tolist()
    return values


def plain(rows: list[Row], between: str, time: float, sender: int, receiver: int) -> float:
    """The same by a walk through the rows of the pair, in the order of time."""
    own = sorted((row for row in rows if row[1:3] == (sender, receiver)), key=lambda row: row[0])
    past = [row for row in own if row[0] <= time]
    if not past:
        return 0.0
    if between == "held":
        return past[-1][3]
    return float(np.interp(time, [row[0] for row in own], [row[3] for row in own]))


ROWS: list[Row] = [(1.0, 0, 1, 0.5), (2.0, 0, 1, 0.75), (4.0, 0, 1, 0.25), (0.0, 1, 0, 1.0)]


def test_a_value_is_held_until_the_next_row_of_its_pair(tmp_path: Path) -> None:
    model = channel(tmp_path, ROWS)
    values = [at(model, time, (0, 1))[0] for time in (0.0, 0.99, 1.0, 1.99, 2.0, 3.0, 4.0, 1e6)]
    assert values == [0.0, 0.0, 0.5, 0.5, 0.75, 0.75, 0.25, 0.25]


def test_between_two_rows_of_a_pair_a_value_may_lie_on_their_line(tmp_path: Path) -> None:
    model = channel(tmp_path, ROWS, "interpolated")
    values = [at(model, time, (0, 1))[0] for time in (0.99, 1.0, 1.5, 2.0, 3.0, 4.0, 1e6)]
    assert values == [0.0, 0.5, 0.625, 0.75, 0.5, 0.25, 0.25]


def test_directions_differ_and_a_pair_without_a_row_decodes_nothing(tmp_path: Path) -> None:
    model = channel(tmp_path, ROWS)
    assert at(model, 1.5, (0, 1), (1, 0), (0, 2), (2, 0), (19, 18)) == [0.5, 1.0, 0.0, 0.0, 0.0]


def test_a_tick_without_pairs_has_no_values(tmp_path: Path) -> None:
    none = np.zeros(0, dtype=np.int64)
    assert channel(tmp_path, ROWS).pair_probability(1.0, none, none, np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("between", ["held", "interpolated"])
def test_many_pairs_at_many_times_agree_with_a_walk_through_the_rows(tmp_path: Path, between: str) -> None:
    rng = np.random.default_rng(5)
    rows: list[Row] = [
        (round(float(rng.uniform(-1, 5)), 1), int(a), int(b), round(float(rng.uniform()), 3))
        for a, b in rng.integers(0, 20, (3000, 2))
    ]
    rows = list({row[:3]: row for row in rows}.values())  # one row per time and pair
    rng.shuffle(rows)
    model = channel(tmp_path, rows, between)
    pairs = [(a, b) for a in range(20) for b in range(20)]
    for time in (-2.0, -0.95, 0.0, 0.1, 1.23, 3.0, 4.999, 7.0):
        expected = [plain(rows, between, time, *pair) for pair in pairs]
        # a line is computed in another order: roundings
        np.testing.assert_allclose(at(model, time, *pairs), expected, rtol=0, atol=0 if between == "held" else 1e-15)


def test_of_two_rows_at_one_time_the_later_one_in_the_file_counts(tmp_path: Path) -> None:
    twice: list[Row] = [(1.0, 0, 1, 0.25), (0.0, 0, 1, 0.0), (1.0, 0, 1, 0.75), (2.0, 0, 1, 0.5)]
    assert at(channel(tmp_path, twice), 1.0, (0, 1)) == [0.75]
    line = channel(tmp_path, twice, "interpolated")
    assert [at(line, time, (0, 1))[0] for time in (0.5, 1.0, 1.5)] == [0.125, 0.75, 0.625]  # a jump at 1 s


@pytest.mark.parametrize("dt", [0.02, 0.07, 0.1, 0.29])
def test_a_row_acts_at_the_tick_of_its_time_although_products_of_ticks_are_rounded(tmp_path: Path, dt: float) -> None:
    ticks = range(1, 400)
    rows: list[Row] = [(round(tick * dt, 9), 0, 1, tick / 1000) for tick in ticks]
    model = channel(tmp_path, rows, dt=dt)
    assert any(tick * dt < round(tick * dt, 9) for tick in ticks) or dt != 0.29
    assert [at(model, tick * dt, (0, 1))[0] for tick in ticks] == [tick / 1000 for tick in ticks]


def test_a_robot_that_does_not_exist_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(FesError, match=r"links\.csv: sender and receiver must be from 0 to 3, got 4$"):
        channel(tmp_path, [(0.0, 0, 1, 1.0), (0.0, 4, 1, 1.0)], robots=4)


def test_a_trace_without_its_checksum_is_refused(tmp_path: Path) -> None:
    config = RadioConfig.model_validate({**settings(tmp_path, ROWS), "trace_sha256": None})
    with pytest.raises(FesError, match="its checksum"):
        TraceChannel(config, WorldContext(DT, 2, ObjectiveConfig(), SeededDraws(1)))


def test_beacons_decode_by_the_direction_and_the_time_of_the_trace(tmp_path: Path) -> None:
    # 0 hears 1 always, 1 hears 0 until 0.1 s, robot 2 hears and is heard by none
    rows: list[Row] = [(0.0, 1, 0, 1.0), (0.0, 0, 1, 1.0), (0.1, 0, 1, 0.0)]
    world, state = started(team([(0, 0), (50, 0), (0, 50)], **settings(tmp_path, rows)))
    fates = []
    for _ in range(10):
        state = stand(world, state)
        fates.append(ledger(state, "reception"))
    assert [fate[0, 1] for fate in fates][1:] == [DECODED] * 9
    # reported a tick after it was sent: those of ticks 1 to 4 (0.08 s) decode, that of tick 5 is lost
    assert [fate[1, 0] for fate in fates][1:] == [DECODED] * 4 + [LOST] * 5
    assert all(fate[pair] == LOST for fate in fates[1:] for pair in ((0, 2), (2, 0), (1, 2), (2, 1)))


def test_jammers_and_bursts_act_on_top_of_a_trace(tmp_path: Path) -> None:
    jam = {"x": 0.0, "y": 0.0, "radius": 10.0, "reception_factor": 0.5}
    rows: list[Row] = [(0.0, 0, 1, 0.5), (0.0, 1, 0, 0.5)]
    bursts = {"bad_share": 0.2, "mean_length": 1.0}
    world, state = started(team([(0, 0), (50, 0)], **settings(tmp_path, rows), jammers=[jam], bursts=bursts))
    probability = ledger(stand(world, state, 3), "probability")
    assert probability[0, 1] == pytest.approx(0.5 * 0.5 * 0.8, rel=1e-15)
    assert probability[1, 0] == pytest.approx(0.5 * 0.8, rel=1e-15)


def test_a_broken_trace_ends_no_run_in_its_midst(tmp_path: Path) -> None:
    at_2_s = {"at": 2.0, "set": {f"channel.{key}": value for key, value in settings(tmp_path, ROWS).items()}}
    scenario = team([(0, 0), (50, 0), (90, 0)], (at_2_s,))
    truth.create(scenario)
    (tmp_path / "links.csv").write_text(HEADER, encoding="utf-8")
    with pytest.raises(FesError, match="has changed"):
        truth.create(team([(0, 0), (50, 0), (90, 0), (130, 0)], (at_2_s,)))


@pytest.mark.parametrize(
    ("between", "expected"), [("held", [0.5, 0.5, 0.75, 0.5]), ("interpolated", [0.5, 0.625, 0.5, 0.5])]
)
def test_pairs_that_are_asked_for_again_get_the_values_of_the_new_time(
    tmp_path: Path, between: str, expected: list[float]
) -> None:
    model = channel(tmp_path, ROWS, between)
    senders, receivers = np.array([0, 1]), np.array([1, 0])
    times = (1.0, 1.5, 3.0, 1.0)  # a model may serve another run, which begins again
    values = [model.pair_probability(time, senders, receivers, np.zeros(2)).tolist() for time in times]
    assert values == [[value, 1.0] for value in expected]
    assert model.pair_probability(1.0, receivers, senders, np.zeros(2)).tolist() == [1.0, 0.5]
