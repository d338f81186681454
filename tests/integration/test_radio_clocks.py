"""The times at which beacons arrive, while the clocks of a robot are disturbed."""

import asyncio
import select
import time

import pytest

from fes.protocol import sealed
from field.radio import socket as radio_socket
from field.radio import wall_clock
from field.radio.settings import RadioSettings
from field.radio.socket import Radio
from tests.support.ears import KEY, RUN, Ear, awaited, comes
from tests.support.forwarding import forwarding
from tests.support.processes import PATIENCE


@pytest.mark.parametrize("is_before", [False, True])
@awaited
async def test_a_process_that_is_held_up_between_two_clocks_moves_no_arrival(
    is_before: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ear, wall, monotonic = Ear(), time.time_ns, time.monotonic_ns
    passed = [0]  # time for which the process was held up [ns]: before or after its first look at the wall clock

    def held_up() -> int:
        before, passed[0] = passed[0], 200_000_000
        return wall() + (passed[0] if is_before else before)

    async with forwarding() as (relay, address):
        with await Radio.opened(RadioSettings(relay=address, key=KEY), RUN, 0, ear) as mine:
            await comes(lambda: len(relay.robots) == 1)
            sent = monotonic()
            relay.inject(0, sealed.seal(KEY, RUN, 1, 5, 0, b"x"))
            assert select.select([mine], [], [], PATIENCE)[0]
            there = monotonic()
            monkeypatch.setattr(time, "time_ns", held_up)
            monkeypatch.setattr(time, "monotonic_ns", lambda: monotonic() + passed[0])
            mine.receive()
    assert passed[0] > 0
    assert sent <= ear.arrived[0] <= there


@awaited
async def test_beacons_that_are_read_by_two_calls_keep_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    ear, ahead = Ear(), wall_clock.ahead
    async with forwarding() as (relay, address):
        with await Radio.opened(RadioSettings(relay=address, key=KEY), RUN, 0, ear) as mine:
            await comes(lambda: len(relay.robots) == 1)
            for number in range(2):
                relay.inject(0, sealed.seal(KEY, RUN, 1, 5, number, b"x"))
            monkeypatch.setattr(radio_socket, "AT_ONCE", 1)
            for error in (1_000_000_000, 0):  # the first arrival is taken for later than it is
                monkeypatch.setattr(wall_clock, "ahead", lambda error=error: ahead() - error)
                assert select.select([mine], [], [], PATIENCE)[0]
                mine.receive()
    assert [beacon.sequence for beacon in ear.heard] == [0, 1]
    assert ear.arrived == sorted(ear.arrived)


@awaited
async def test_a_clock_that_jumps_moves_no_arrival(monkeypatch: pytest.MonkeyPatch) -> None:
    arrivals: list[int] = []
    async with forwarding() as (relay, address):
        settings = RadioSettings(relay=address, key=KEY)
        with await Radio.opened(settings, RUN, 0, lambda beacon, at: arrivals.append(at)) as mine:
            await comes(lambda: len(relay.robots) == 1)
            for number, jump in enumerate((0, -3_600_000_000_000, 3_600_000_000_000)):
                before, wall = time.monotonic_ns(), time.time_ns
                relay.inject(0, sealed.seal(KEY, RUN, 1, 5, number, b"x"))
                monkeypatch.setattr(time, "time_ns", lambda wall=wall, jump=jump: wall() + jump)
                async with asyncio.timeout(PATIENCE):
                    while len(arrivals) <= number:
                        mine.receive()
                        await asyncio.sleep(0.001)
                monkeypatch.undo()
                assert before - 1_000_000_000 <= arrivals[-1] <= time.monotonic_ns()
