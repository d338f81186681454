"""CPU time of a world and of a separate router with a hundred robots; rate of the lockstep behind a delay.

World and router are separate processes, so that the CPU time of each can be measured. Each robot has a session in
this process. A relay delays every byte, so the kernel needs no means to delay traffic.
"""

import asyncio
import contextlib
import subprocess
import sys
import time
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

from agents.process import Agent
from bench.size.growth import SCENARIO, Counted, Counts
from bench.size.own_router import SOURCE
from console.backends.process_group import free_port
from console.connect import observer
from fes.protocol import keys
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from world.config.scenario import load
from world.execution.run import Run
from world.server.server import Server

FIRST, LAST = 30, 130
"""Measured window [ticks]."""

ROBOTS = (25, 50, 100)
DELAYS = (0.0, 0.005, 0.010, 0.020)
"""One way [s]."""


@contextmanager
def started(*words: str) -> Iterator["subprocess.Popen[str]"]:
    """A program that ends when its standard input is closed."""
    process = subprocess.Popen(
        [sys.executable, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        yield process
    finally:
        process.communicate(timeout=30)


def spent(pid: int) -> float:
    """CPU time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


async def cost(robots: int) -> None:
    """Print the CPU time per tick of world and router."""
    endpoint, counts = f"tcp/127.0.0.1:{free_port()}", Counts()
    words = [str(SCENARIO), "-m", "client", "-e", endpoint, "--set", f"robots.count={robots}", "--exit-with-stdin"]
    with started("-c", SOURCE, endpoint) as router:
        assert router.stdout is not None
        router.stdout.readline()
        with started("-m", "world.process", *words) as world:
            agents = [asyncio.ensure_future(_live(endpoint, robot, counts)) for robot in range(robots)]
            marks = [mark async for mark in _marks(endpoint, world.pid, router.pid, counts)]
            for agent in agents:
                agent.cancel()
            await asyncio.gather(*agents, return_exceptions=True)
    (tick, before, *cpu), (end, after, *total) = marks
    ticks, messages = end - tick, Counter(after)
    messages.subtract(before)
    # In: a beacon, a command, an observation from the world. Out: the last two, and the beacon to each peer.
    handled = 2 * messages["command put"] + 2 * messages["observation taken"]
    handled += messages["beacon put"] + messages["beacon taken"]
    of_world, of_router = (now - then for then, now in zip(cpu, total, strict=True))
    print(
        f"  {robots:4d} robots: world {1e6 * of_world / ticks / robots:5.1f} us per robot-tick; "
        f"router {handled / ticks:6.0f} messages per tick, {1e6 * of_router / handled:4.1f} us each",
        flush=True,
    )


async def _live(endpoint: str, robot: int, counts: Counts) -> None:
    async with bus.opened(Endpoints("client", (endpoint,))) as opened:
        agent = Agent(Counted(opened, counts), keys.DEFAULT_RUN, (robot,))
        await agent.live(await agent.join(60.0))


async def _marks(
    endpoint: str, world: int, router: int, counts: Counts
) -> AsyncIterator[tuple[int, Counts, float, float]]:
    """Tick, messages and CPU times at both ends of the window."""
    waiting = [FIRST, LAST]
    async with bus.opened(Endpoints("client", (endpoint,))) as opened:
        async for report in observer.reports(opened, keys.DEFAULT_RUN, 60.0, 60.0):
            if report is not None and report.tick >= waiting[0]:
                waiting.pop(0)
                yield report.tick, Counter(counts), spent(world), spent(router)
                if not waiting:
                    return


@asynccontextmanager
async def relayed(port: int, delay: float) -> AsyncIterator[int]:
    """The port of a relay that holds every byte for `delay` [s], in both directions."""

    async def carry(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        loop = asyncio.get_running_loop()
        with contextlib.suppress(OSError):
            while data := await reader.read(1 << 16):
                loop.call_later(delay, writer.write, data)
        loop.call_later(delay, writer.close)

    async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        onward = await asyncio.open_connection("127.0.0.1", port)
        with contextlib.suppress(asyncio.CancelledError):  # the benchmark ends
            await asyncio.gather(carry(reader, onward[1]), carry(onward[0], writer))

    server = await asyncio.start_server(accept, "127.0.0.1", 0)
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        server.close()


async def pace(delay: float) -> float:
    """Ticks per second of two robots behind a relay."""
    port = free_port()
    async with (
        bus.opened(Endpoints("router", (), (f"tcp/127.0.0.1:{port}",))) as opened,
        relayed(port, delay) as relay_port,
    ):
        server = Server(opened, Run(load(Path("configs/pair.toml"), {"run.duration": 2.0})), "pair", keys.DEFAULT_RUN)
        agents = [asyncio.ensure_future(_live(f"tcp/127.0.0.1:{relay_port}", robot, Counts())) for robot in range(2)]
        await server.gather()
        begun = time.perf_counter()
        await server.main_loop()
        rate = server.run.state.tick / (time.perf_counter() - begun)
        server.dismiss()
        await asyncio.gather(*agents)
        return float(rate)


def main() -> None:
    """Print costs and rates."""
    print(f"cost: {SCENARIO}, world and router in separate processes, one session per robot")
    for robots in ROBOTS:
        asyncio.run(cost(robots))
    rest = 0.0
    for delay in DELAYS:
        rate = asyncio.run(pace(delay))
        rest = rest or 1.0 / rate
        bound = 1.0 / (2.0 * delay + rest)
        bound_text = f"1 / (2 x delay + {1e3 * rest:.1f} ms) = {bound:.1f}"
        print(f"  {1e3 * delay:4.0f} ms one way: {rate:6.1f} ticks/s; {bound_text}", flush=True)


if __name__ == "__main__":
    main()
