"""Marks in beacons: sizes, turns, and which marks a robot accepts, one rule at a time."""

from collections.abc import Iterable

import numpy as np
import pytest

from agents.configuration import table as tables
from agents.configuration.exchange import EMPTY, MOST, Exchange
from agents.configuration.table import NOW, Table
from agents.control import contacts
from fes.arrays.types import Bytes, Ints
from fes.extension.neighborhood import Neighborhood
from tests.support import layouts

Mark = tuple[int, float, float, float]
"""Id, x, y and estimate."""

RELAYED = 8


def exchange(own: Iterable[int] = (0,), farthest: float | None = None, most: int = MOST) -> Exchange:
    return Exchange(np.array(list(own)), lambda ids: ids, RELAYED, most, farthest)


NO_MARK = (EMPTY, 0.0, 0.0, 0.0)


def message(epoch: int, *relayed: Mark, own: Mark = NO_MARK) -> Bytes:
    """The bytes of a beacon, built field by field; places without a mark are empty."""
    data = np.uint32(epoch).tobytes()
    for number, x, y, estimate in [own, *relayed, *[NO_MARK] * (RELAYED - len(relayed))]:
        data += np.uint16(number).tobytes() + np.array([x, y, estimate], dtype=np.float32).tobytes()
    return np.frombuffer(data, dtype=np.uint8)


def hearing(own: Iterable[int], beacons: dict[tuple[int, int], Bytes], tick: int = 9) -> Neighborhood:
    """The neighborhood at a tick at which each (robot, peer) has just heard these bytes."""
    edges = layouts.edges(own, beacons)
    count, zeros = len(edges), np.zeros(len(edges))
    order = sorted(beacons)
    known = contacts.no_contacts(edges.ids, 0, 0)._replace(
        edges=edges,
        heard=np.full(count, tick - 1),
        x=zeros,
        declared=np.array([beacons[pair] for pair in order], dtype=np.uint8).reshape(count, -1),
    )
    return Neighborhood(tick, 0.02, np.zeros((len(edges.ids), 3)), known, known, edges, np.arange(count))


def hear(known: Table, *beacons: Bytes, epoch: int = 5, farthest: float | None = None, most: int = MOST) -> Table:
    """The table of robot 0 after it heard these beacons, those of robots 1, 2, ... ."""
    around = hearing([0], {(0, 1 + peer): data for peer, data in enumerate(beacons)})
    return exchange([0], farthest, most).hear(known, np.array([epoch]), around)


def blank(*own: int) -> Table:
    return tables.empty(len(own) or 1, np.array(own or (0,)))


def marks_of(known: Table, row: int = 0) -> dict[int, list[float]]:
    """Id -> mark of the present period."""
    ids, marks = known.known(row)
    return dict(zip(ids.tolist(), marks.tolist(), strict=True))


@pytest.mark.parametrize(("relayed", "size"), [(1, 32), (8, 130), (16, 242)])
def test_the_bytes_of_a_beacon_are_those_of_its_layout(relayed: int, size: int) -> None:
    assert Exchange(np.array([0]), lambda ids: ids, relayed, MOST, None).size == size
    assert message(0).size == 130


def test_a_mark_arrives_as_it_was_sent() -> None:
    sender = exchange([1])
    known = tables.with_own(blank(1), np.array([0]), np.array([1]), np.array([(10.5, -2.25, 71.0)]))
    data, _ = sender.send(known, np.array([5]), np.array([-1]))
    assert data.tobytes() == message(5, own=(1, 10.5, -2.25, 71.0)).tobytes()
    assert marks_of(hear(blank(), data[0])) == {1: [10.5, -2.25, 71.0]}


def test_a_robot_may_only_speak_its_own_mark() -> None:
    """Over TLS no other robot can send its beacons. Without TLS this only finds mistakes."""
    claimed = message(5, own=(7, 1.0, 1.0, 70.0))
    assert marks_of(hear(blank(), claimed)) == {}
    assert marks_of(hear(blank(), message(5, own=(1, 1.0, 1.0, 70.0)))) == {1: [1.0, 1.0, 70.0]}
    around = hearing([0], {(0, 101): message(5, own=(1, 1.0, 1.0, 70.0))})  # a crew of many runs: robot 1 of its run
    stacked = Exchange(np.array([0]), lambda ids: ids % 100, RELAYED, MOST, None)
    assert marks_of(stacked.hear(blank(), np.array([5]), around)) == {1: [1.0, 1.0, 70.0]}


def test_all_marks_of_others_are_relayed_by_turns() -> None:
    others = list(range(1, 20))
    known = hear(blank(0), *(message(5, (n, float(n), 0.0, 70.0)) for n in others))
    sender, last = exchange(), np.array([-1])
    sent: list[int] = []
    for _ in range(5):
        data, last = sender.send(known, np.array([5]), last)
        ids = np.frombuffer(data.tobytes()[4:], dtype=[("id", "<u2"), ("mark", "<f4", (3,))])["id"].tolist()
        assert ids[0] == EMPTY  # it has no mark of its own
        sent += ids[1:]
    assert sent == [others[k % 19] for k in range(5 * RELAYED)]


def test_the_first_mark_of_an_id_stays() -> None:
    first, second = message(5, (7, 1.0, 1.0, 70.0)), message(5, (7, 2.0, 2.0, 80.0))
    known = hear(blank(), first, second)
    assert marks_of(known) == {7: [1.0, 1.0, 70.0]}
    assert marks_of(hear(known, second)) == {7: [1.0, 1.0, 70.0]}
    assert marks_of(hear(blank(), second, first)) == {7: [2.0, 2.0, 80.0]}


@pytest.mark.parametrize("epoch", [5, 2**32 - 1, 2**33 + 7])
def test_marks_of_the_present_and_the_next_period_count_and_no_others(epoch: int) -> None:
    beacons = [message((epoch + ahead) % 2**32, (ahead + 20, 1.0, 1.0, 70.0)) for ahead in (-2, -1, 0, 1, 2)]
    known = hear(blank(), *beacons, epoch=epoch)
    assert set(marks_of(known)) == {20}
    assert set(marks_of(tables.advance(known, np.array([1])))) == {21}
    assert set(marks_of(tables.advance(known, np.array([2])))) == set()


@pytest.mark.parametrize(
    "mark",
    [
        (7, np.nan, 0.0, 70.0),
        (7, 0.0, np.inf, 70.0),
        (7, 2e9, 0.0, 70.0),
        (7, 0.0, 0.0, 0.0),
        (7, 0.0, 0.0, -70.0),
        (7, 0.0, 0.0, np.nan),
        (EMPTY, 0.0, 0.0, 70.0),
    ],
)
def test_a_mark_with_impossible_numbers_is_refused(mark: Mark) -> None:
    assert marks_of(hear(blank(), message(5, mark, (8, 0.0, 0.0, 70.0)))) == {8: [0.0, 0.0, 70.0]}


def test_a_peer_with_another_law_is_ignored() -> None:
    assert marks_of(hear(blank(), np.zeros(130, dtype=np.uint8), epoch=0)) == {}


def test_a_robot_takes_its_own_mark_from_the_air_only_if_it_has_none() -> None:
    forged = message(5, (0, 90.0, 0.0, 70.0))
    assert marks_of(hear(blank(), forged)) == {0: [90.0, 0.0, 70.0]}  # it was restarted, and adopts it
    own = tables.with_own(blank(), np.array([0]), np.array([0]), np.array([(1.0, 2.0, 71.0)]))
    assert marks_of(hear(own, forged)) == {0: [1.0, 2.0, 71.0]}


def test_a_robot_never_takes_its_own_mark_of_the_next_period() -> None:
    known = hear(blank(), message(6, (0, 90.0, 0.0, 70.0), (7, 90.0, 0.0, 70.0)))
    assert set(marks_of(tables.advance(known, np.array([1])))) == {7}


@pytest.mark.parametrize(("periods", "way"), [(1, 31.0), (3, 51.0), (30, 321.0)])
def test_a_mark_further_than_its_robot_can_have_moved_is_refused(periods: int, way: float) -> None:
    known = hear(blank(), message(5, (7, 100.0, 0.0, 70.0)), farthest=10.0)
    known = tables.advance(known, np.array([periods]))
    for x, is_accepted in [(100.0 + way, True), (100.0 - way, True), (101.0 + way, False), (99.0 - way, False)]:
        later = hear(known, message(5 + periods, (7, x, 0.0, 70.0)), epoch=5 + periods, farthest=10.0)
        assert (7 in marks_of(later)) == is_accepted


def test_without_a_limit_of_speed_each_place_is_possible() -> None:
    known = tables.advance(hear(blank(), message(5, (7, 100.0, 0.0, 70.0))), np.array([1]))
    assert 7 in marks_of(hear(known, message(6, (7, 9e5, 0.0, 70.0)), epoch=6))


def test_a_mark_is_forgotten_after_thirty_periods() -> None:
    known = tables.advance(hear(blank(), message(5, (7, 100.0, 0.0, 70.0)), farthest=10.0), np.array([31]))
    assert 7 in marks_of(hear(known, message(36, (7, 9e5, 0.0, 70.0)), epoch=36, farthest=10.0))


def test_a_robot_knows_at_most_so_many_marks_of_a_period() -> None:
    known = blank()
    for first in range(1, 400, 8):
        known = hear(known, message(5, *((first + k, 0.0, 0.0, 70.0) for k in range(8))), most=20)
    assert sorted(marks_of(known)) == list(range(1, 20))  # the last place is that of its own mark
    assert sorted(marks_of(hear(blank(), *(message(5, (n, 0.0, 0.0, 70.0)) for n in range(1, 31)), most=20))) == list(
        range(1, 20)
    )
    assert 0 in marks_of(hear(known, message(5, (0, 0.0, 0.0, 70.0)), most=20))


def test_forged_marks_of_the_next_period_leave_a_place_for_the_own_mark() -> None:
    known = blank()
    for first in range(1, 400, 8):
        known = hear(known, message(6, *((first + k, 0.0, 0.0, 70.0) for k in range(8))), most=20)
    turned = tables.advance(known, np.array([1]))
    assert len(marks_of(tables.with_own(turned, np.array([0]), np.array([0]), np.zeros((1, 3))))) == 20


@pytest.mark.parametrize("own", [0, 40_000])
def test_a_flood_of_invented_ids_does_not_displace_the_own_id(own: int) -> None:
    known = blank(own)
    for first in range(1, 2000, 8):
        around = hearing([own], {(own, 1): message(5, *((first + k, 0.0, 0.0, 70.0) for k in range(8)))})
        known = exchange([own], None, 10).hear(known, np.array([5]), around)
    assert own in known.ids
    mine = tables.with_own(known, np.array([0]), np.array([own]), np.ones((1, 3)))
    data, _ = exchange([own]).send(mine, np.array([5]), np.array([-1]))
    assert data[0, 4:6].tobytes() == np.uint16(own).tobytes()


def test_a_flood_of_invented_ids_does_not_grow_the_table_for_ever() -> None:
    known, epoch = blank(), 5
    for start in range(0, 60_000, 88):
        beacons = [message(epoch, *((1 + start + 8 * b + k, 0.0, 0.0, 70.0) for k in range(8))) for b in range(11)]
        known = tables.advance(hear(known, *beacons, epoch=epoch), np.array([1]))
        epoch += 1
    assert len(known.ids) < 100 * 34  # those of 30 periods, and of the last ones


def test_the_marks_of_a_robot_do_not_depend_on_its_crew() -> None:
    data = {(0, 9): message(5, (9, 1.0, 0.0, 70.0)), (2, 9): message(5, (8, 2.0, 0.0, 70.0), (0, 3.0, 0.0, 70.0))}
    both = exchange([0, 2]).hear(blank(0, 2), np.array([5, 5]), hearing([0, 2], data))
    for row, robot in enumerate((0, 2)):
        own = {pair: value for pair, value in data.items() if pair[0] == robot}
        alone = exchange([robot]).hear(blank(robot), np.array([5]), hearing([robot], own))
        assert marks_of(alone) == marks_of(both, row)
        sent: list[tuple[Bytes, Ints]] = [
            exchange([0, 2]).send(both, np.array([5, 5]), np.array([-1, -1])),
            exchange([robot]).send(alone, np.array([5]), np.array([-1])),
        ]
        assert sent[0][0][row].tobytes() == sent[1][0][0].tobytes()
        assert sent[0][1][row] == sent[1][1][0]


def test_a_restarted_robot_knows_no_mark() -> None:
    data = {(0, 9): message(5, (9, 1.0, 0.0, 70.0)), (2, 9): message(5, (9, 1.0, 0.0, 70.0))}
    known = exchange([0, 2]).hear(blank(0, 2), np.array([5, 5]), hearing([0, 2], data))
    after = tables.forget(known, np.array([True, False]))
    assert (marks_of(after, 0), marks_of(after, 1)) == ({}, {9: [1.0, 0.0, 70.0]})
    assert after.counts(np.array([0, 2])).tolist() == [1, 2]
    assert not known.is_known[NOW, :, 0].any()
