"""The times at which beacons arrive, while the clocks of a robot are disturbed."""

import asyncio
import select
import time

import pytest

from fes.protocol import sealed
from field.radio.settings import RadioSettings
from field.radio.socket import Radio
from tests.support.ears import KEY, RUN, Ear, awaited, comes
from tests.support.forwarding import forwarding
from tests.support.processes import PATIENCE


@awaited
async def test_a_process_that_is_held_up_between_two_clocks_moves_no_arrival(monkeypatch: pytest.MonkeyPatch) -> None:
    ear, looked, wall = Ear(), [0], time.time_ns

    def held_up_once() -> int:
        now, looked[0] = wall(), looked[0] + 1
        if looked[0] == 1:
            time.sleep(0.2)
        return now

    async with forwarding() as (relay, address):
        with await Radio.opened(RadioSettings(relay=address, key=KEY), RUN, 0, ear) as mine:
            await comes(lambda: len(relay.robots) == 1)
            relay.inject(0, sealed.seal(KEY, RUN, 1, 5, 0, b"x"))
            assert select.select([mine], [], [], PATIENCE)[0]
            there = time.monotonic_ns()
            monkeypatch.setattr(time, "time_ns", held_up_once)
            mine.receive()
    assert looked[0] > 1
    assert ear.arrived[0] <= there


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
