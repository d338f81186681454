"""The ledger that the radio keeps of each contact."""

import dataclasses
import math

import numpy as np
import pytest

from fes.model.sensing import CLOSED, DECODED, LOST
from tests.support import layouts
from tests.support.radios import EVERYTHING, Pair, ledger, stand, started, team
from world.config.radio import JammerConfig
from world.simulation import truth


def test_the_ledger_of_a_short_history_is_that_counted_by_hand() -> None:
    # A perfect radio, jammed at robot 0 for the beacons of ticks 2, 3, 6, 7, 8; the first beacon is that of tick 1.
    world, state = started(team([(0, 0), (60, 0)], model="perfect"))
    clear = state.channel
    jammed = clear.model_copy(update={"jammers": [JammerConfig(x=0.0, y=0.0, radius=1.0)]})
    rows = []
    for tick in range(10):
        state = dataclasses.replace(state, channel=jammed if tick in (2, 3, 6, 7, 8) else clear)
        state = stand(world, state)
        columns = ("reception", "sent", "decoded", "gap", "longest_gap", "outage_sum", "probability")
        rows.append(tuple(ledger(state, name)[0, 1] for name in columns))
        assert ledger(state, "decoded")[1, 0] == ledger(state, "sent")[1, 0] == max(0, tick)
        assert ledger(state, "longest_gap")[1, 0] == ledger(state, "outage_sum")[1, 0] == 0
    assert rows == [
        (CLOSED, 0, 0, 0, 0, 0.0, 1.0),
        (DECODED, 1, 1, 0, 0, 0.0, 1.0),
        (LOST, 2, 1, 1, 1, 1.0, 0.0),
        (LOST, 3, 1, 2, 2, 2.0, 0.0),
        (DECODED, 4, 2, 0, 2, 2.0, 1.0),
        (DECODED, 5, 3, 0, 2, 2.0, 1.0),
        (LOST, 6, 3, 1, 2, 3.0, 0.0),
        (LOST, 7, 3, 2, 2, 4.0, 0.0),
        (LOST, 8, 3, 3, 3, 5.0, 0.0),
        (DECODED, 9, 4, 0, 3, 5.0, 1.0),
    ]


def test_the_ledger_equals_a_recount_of_the_verdicts_while_contacts_open_and_close() -> None:
    world, state = started(team([(0, 0), (120, 0), (-170, 60), (60, 90)]))
    twists = np.array([[0.0, 0.0], [0.0, 0.0], [75.0, 0.0], [0.0, 0.0]])  # robot 2 passes by, 1.5 m a tick
    recount: dict[Pair, dict[str, float]] = {}
    seen = set()
    for _ in range(320):
        poses = state.poses
        state = truth.step(world, state, twists)
        verdicts = ledger(state, "reception")
        recount = {
            pair: recount.get(pair, dict.fromkeys(("sent", "decoded", "gap", "longest_gap", "outage_sum"), 0))
            for pair in verdicts
        }
        for pair, code in verdicts.items():
            row = recount[pair] = dict(recount[pair])
            if code != CLOSED:
                row["sent"] += 1
                row["decoded"] += code == DECODED
                row["gap"] = 0 if code == DECODED else row["gap"] + 1
                row["longest_gap"] = max(row["longest_gap"], row["gap"])
                row["outage_sum"] += 1.0 - math.exp(-3e-7 * layouts.distance(poses, *pair) ** 3)
        for name in ("sent", "decoded", "gap", "longest_gap"):
            assert ledger(state, name) == {pair: row[name] for pair, row in recount.items()}
        metrics = {pair: row["outage_sum"] for pair, row in recount.items()}
        assert ledger(state, "outage_sum") == pytest.approx(metrics, rel=1e-11)  # 320 roundings
        seen.add(len(verdicts))
    assert {6, 12} <= seen
    assert len(ledger(state, "sent")) == 6  # it has gone


def test_the_number_of_lost_beacons_agrees_with_the_outage_sum() -> None:
    scenario = team([(0, 0), (70, 0), (0, 90), (80, 80)], **{**EVERYTHING, "model": "rayleigh"})
    world, state = started(scenario)
    ticks = 4000
    state = stand(world, state, ticks)
    lost = state.radio.sent - state.radio.decoded
    # the chain of the bursts forgets 1 - 0.1 - 0.1/9 = 0.89 a tick
    sigma = math.sqrt(ticks) * math.hypot(0.5, 0.9 * math.sqrt(0.09 * 1.889 / 0.111))
    assert (abs(lost - state.radio.outage_sum) < 4.0 * sigma).all()
    assert (state.radio.outage_sum > 100.0).all()  # a tenth of 4000 x 0.9 at least


def test_a_pair_that_has_just_come_in_range_has_no_probability_yet() -> None:
    world, state = started(team([(0, 0), (60, 0)]))
    assert all(math.isnan(p) for p in ledger(state, "probability").values())
    assert not any(math.isnan(p) for p in ledger(stand(world, state), "probability").values())
