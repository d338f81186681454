"""A program that publishes forged messages on every tick of a run."""

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path

import zenoh

from fes.protocol import keys, messages
from fes.transport.bus import Bus
from tests.support.stage import RUN, stage


async def forge(attacker: Bus, key: str, forged: Callable[[int], bytes], is_over: Callable[[], bool]) -> int:
    """Publish on `key` the `forged` message of the next tick until the run is over; return the number of ticks seen.

    Robot 1 marks the time: it receives only the world, and the programs that the world authorizes.
    """
    marks = [b""]  # without TLS any program can overhear the mark of an agent's commands

    def overhear(sample: zenoh.Sample) -> None:
        marks[0] = sample.attachment.to_bytes() if sample.attachment is not None else b""

    callback = zenoh.handlers.Callback(overhear, indirect=False)
    listening = attacker._session.declare_subscriber(keys.command(RUN, 0), callback)
    clock, ticks = attacker.mailbox(keys.beacon(RUN, 1)), set[int]()
    while not is_over():
        while (heard := clock.take()) is not None:
            assert heard[1] is not None
            ticks.add(messages.decode_beacon(heard[1]).tick)
        if ticks:
            attacker._session.put(key, forged(max(ticks) + 1), attachment=marks[0])
        await asyncio.sleep(0.001)
    listening.undeclare()
    return len(ticks)


async def run_with_a_forger(
    where: Path, keyed: Path | None, key: str, forged: Callable[[int], bytes], words: Sequence[str] = ()
) -> tuple[str, str]:
    """Digest and log of a run in which robot 1, or without TLS any client, impersonates robot 0."""
    async with stage(where, keyed, words) as world, world.visitor("robot-1") as attacker:
        world.agent(0)
        world.agent(1)
        over = asyncio.ensure_future(world.over())
        ticks = await forge(attacker, key, forged, over.done)
        good = await over
        if keyed:  # without TLS it may end the run early, on a slow machine
            assert good, world.log()
            assert ticks > 10
        return world.digest(), world.log()
