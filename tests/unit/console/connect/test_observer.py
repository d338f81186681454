"""An observer of a run whose world comes, goes, and speaks otherwise, on a clock that jumps."""

import asyncio
from collections.abc import AsyncIterator, Callable
from functools import partial
from typing import Any

import msgpack
import pytest

from console.backends import fault_injection
from console.connect import observer
from fes.errors import MessageError, Unavailable
from fes.protocol.report import Report, encode_report
from tests.support import jumping_clock as jumps
from tests.support.frames import a_report
from tests.support.loop import load

IDLE = 0.25
TICKS = 1000


def report(tick: int) -> bytes:
    return encode_report(a_report([(0.0, 0.0)], tick=tick, ticks=TICKS))


def of_another_version(tick: int) -> bytes:
    version, *fields = msgpack.unpackb(report(tick))
    return msgpack.packb([version - 1, *fields])  # type: ignore[no-any-return]


class World:
    """Stands for the bus, and says and does what a world might."""

    def __init__(self) -> None:
        self.declared: list[str] = []
        """Keys of the subscriptions that have not ended."""

    def declare_subscriber(self, key: str, heard: Callable[[str, bytes | None], None]) -> Callable[[], None]:
        self._report, self._heard = key, heard
        return self._declare(key)

    def declare_liveliness_subscriber(self, key: str, seen: Callable[[str, bool], None]) -> Callable[[], None]:
        self._alive, self._seen = key, seen
        return self._declare(key)

    def _declare(self, key: str) -> Callable[[], None]:
        self.declared.append(key)
        return partial(self.declared.remove, key)

    async def act(self, *acts: tuple[float, bool | bytes]) -> None:
        """At each time [s] a token that comes or goes, or a payload."""
        for time, event in acts:
            await asyncio.sleep(time - asyncio.get_running_loop().time())
            if isinstance(event, bool):
                self._seen(self._alive, event)
            else:
                self._heard(self._report, event)


def seen(timeout: float, *acts: tuple[float, bool | bytes], busy: float = 0.0) -> tuple[list[int], Any, float]:
    """The ticks that are shown to a reader who is `busy` [s] with each, the error if there is one, and when [s]."""

    async def story() -> tuple[list[int], Any, float]:
        world, ticks, loop = World(), list[int](), asyncio.get_running_loop()
        reading = observer.reports(world, "test", timeout, IDLE)  # type: ignore[arg-type]
        acting = asyncio.ensure_future(world.act(*acts))
        try:
            async for one in reading:
                if one is not None:
                    ticks.append(one.tick)
                    await asyncio.sleep(busy)
        except (Unavailable, MessageError) as error:
            return ticks, error, loop.time()
        finally:
            await acting
            assert world.declared == []  # an observer that has ended leaves no subscription
        return ticks, None, loop.time()

    result: tuple[list[int], Any, float] = jumps.run(story())
    return result


@pytest.mark.parametrize(("timeout", "waits"), [(5.0, 15.0), (15.0, 15.0), (30.0, 30.0), (60.0, 60.0)])
def test_an_observer_waits_as_long_for_a_world_that_left_as_for_a_future_one(timeout: float, waits: float) -> None:
    ticks, error, when = seen(timeout, (1.0, True), (2.0, report(7)), (3.0, False))
    assert ticks == [7]
    assert str(error) == "the world of run 'test' left after tick 7"
    assert waits < when - 3.0 <= waits + 2 * IDLE


def test_an_observer_waits_for_a_world_until_the_timeout() -> None:
    ticks, error, when = seen(5.0, (1.0, report(7)[:-1]))
    assert (ticks, str(error)) == ([], "the world of run 'test' did not appear within 5 s")
    assert 5.0 < when <= 5.0 + 2 * IDLE


def test_a_world_is_not_missed_while_the_reader_is_busy() -> None:
    """A caller that replaces a world after 20 s sees none for 30 s if the new one starts slowly."""
    acts = (1.0, True), (2.0, report(7)), (3.0, False), (32.0, True), (33.0, report(TICKS - 1)), (54.0, False)
    ticks, error, _ = seen(5.0, *acts, busy=20.0)
    assert (ticks, error) == ([7, TICKS - 1], None)


def test_the_wait_for_a_world_that_does_not_return_begins_when_the_busy_reader_continues() -> None:
    _, error, when = seen(5.0, (1.0, True), (2.0, report(7)), (3.0, False), busy=20.0)
    assert isinstance(error, Unavailable)
    assert observer.RETURN < when - 22.0 <= observer.RETURN + 2 * IDLE


def test_an_observer_that_receives_only_another_version_reports_it() -> None:
    strange = [(1.0 + 0.1 * index, of_another_version(index)) for index in range(50)]
    ticks, error, when = seen(30.0, (0.5, True), *strange)
    assert (ticks, str(error)) == ([], "Report: speaks protocol 4, got version: 3")
    assert when <= 1.0 + observer.FOREIGN_PERIOD + IDLE  # as soon as the world has said enough, for long enough


def test_a_flood_of_another_version_before_the_first_report_hides_no_report() -> None:
    strange = [(1.0 + 0.001 * index, of_another_version(index)) for index in range(500)]
    ticks, error, _ = seen(5.0, (0.5, True), *strange, (2.0, report(7)), (6.0, report(TICKS - 1)), (7.0, False))
    assert (ticks, error) == ([7, TICKS - 1], None)


def test_junk_of_another_version_between_reports_hides_no_report() -> None:
    strange = [(3.0 + 0.1 * index, of_another_version(index)) for index in range(20)]
    ticks, error, _ = seen(5.0, (1.0, True), (2.0, report(7)), *strange, (6.0, report(TICKS - 1)), (7.0, False))
    assert (ticks, error) == ([7, TICKS - 1], None)


@pytest.mark.parametrize(
    ("lost", "did"),
    [
        (True, ["stop 2", "stop 3", "kill 3", "resume 2", "resume 3"]),  # the world may still wait for robot 2
        (False, ["stop 2", "stop 3", "kill 2", "kill 3", "resume 2", "resume 3"]),  # no world waits
    ],
    ids=["lost from sight", "over"],
)
def test_a_robot_that_is_due_to_wake_is_not_killed_when_contact_with_the_world_is_lost(
    monkeypatch: pytest.MonkeyPatch, lost: bool, did: list[str]
) -> None:
    scenario = load("paper.toml", event=[{"at": 2.0, "hang": [2, 3]}, {"at": 30.0, "wake": [2]}])
    done: list[str] = []

    async def reports(*words: Any) -> AsyncIterator[Report]:
        yield a_report([(0.0, 0.0)], tick=150, ticks_per_s=50.0)
        if lost:
            raise Unavailable("the world left")

    async def kill(ids: str) -> None:
        done.append(f"kill {ids}")

    async def away(seconds: float) -> None:
        done.append("away")

    def note(verb: str) -> Callable[[str], None]:
        return lambda ids: done.append(f"{verb} {ids}")

    monkeypatch.setattr("console.connect.observer.reports", reports)
    control = fault_injection.ProcessControl(kill, kill, note("stop"), note("resume"), away)
    jumps.run(fault_injection.enact(None, "test", 1.0, scenario, control, alone=True))  # type: ignore[arg-type]
    assert done == did
