"""Messages and bytes per tick at the world's router, for 10 to 100 robots with a session each.

Each robot has its own session and connection, in the same process as the world. Messages are counted
where they are put and taken. Bytes are those that the kernel counts on the router's connections (`ss`, of iproute2):
with Zenoh's framing, without the headers of TCP and IP.
"""

import asyncio
import re
import subprocess
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from agents.process import Agent
from console.backends import inprocess
from console.backends.process_group import free_port
from fes.recording.layout import NAME
from fes.transport import bus
from fes.transport.bus import Bus, Gate, Handler, Mailbox
from fes.transport.endpoints import Endpoints
from world.config.scenario import Scenario, load
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.server.server import Server
from world.simulation import truth
from world.simulation.truth import State

RUN = "growth"
SCENARIO = Path("configs/hundred.toml")
ROBOTS = (10, 25, 50, 100)
FIRST, TICKS = 20, 60
"""Counted window [ticks]."""

LATER = 60.0
"""Simulated time until the formation is complete, after which its contacts and its log are measured [s]."""

KINDS = ("observation", "beacon", "command")

Counts = Counter[str]
"""Numbers of messages, and of their bytes, by kind and action."""


class Counted(Bus):
    """A bus that counts messages put and taken, by kind."""

    def __init__(self, opened: Bus, counts: Counts, beacons: str = "beacon taken") -> None:
        """Beacons taken are counted as the kind `beacons`: those that the world takes cross no connection."""
        self.__dict__.update(opened.__dict__)
        self.counts = counts
        self.beacons = beacons

    def declare_publisher(
        self, key: str, schema: str, *, drop: bool = False, mark: bytes | None = None
    ) -> Callable[[bytes], None]:
        """Declare a publisher that counts its messages."""
        put, kind = super().declare_publisher(key, schema, drop=drop, mark=mark), key.rpartition("/")[2]

        def counted(payload: bytes) -> None:
            self._count(f"{kind} put", payload)
            put(payload)

        return counted

    def declare_subscriber(self, key: str, handler: Handler, gate: Gate | None = None) -> Callable[[], None]:
        """Declare a subscriber that counts its messages."""
        kind = key.rpartition("/")[2]

        def counted(sample: str, payload: bytes | None) -> None:
            self._count(f"{kind} taken", payload)
            handler(sample, payload)

        return super().declare_subscriber(key, counted, gate)

    def mailbox(self, key: str) -> Mailbox:
        """A mailbox that counts the messages taken from it."""
        box = super().mailbox(key)
        take = box.take

        def counted() -> tuple[str, bytes | None] | None:
            sample = take()
            if sample is not None:
                self._count(self.beacons, sample[1])
            return sample

        box.take = counted  # type: ignore[method-assign]
        return box

    def _count(self, what: str, payload: bytes | None) -> None:
        self.counts[what] += 1
        self.counts[f"{what}, bytes"] += len(payload or b"")


@dataclass(frozen=True)
class Grown:
    """Load of the router per tick."""

    robots: int
    contacts: float
    """Mean number of peers in range of a robot."""
    counts: dict[str, float]
    """Messages, and bytes of payload, per tick by kind."""
    received: float
    """Bytes per tick into the router's connections."""
    sent: float

    @property
    def incoming(self) -> float:
        """Messages per tick from robots to the router."""
        return self.counts["beacon put"] + self.counts["command put"]

    @property
    def outgoing(self) -> float:
        """Messages per tick from the router to robots."""
        return self.counts["beacon taken"] + self.counts["observation taken"]


def measure(scenario: Scenario) -> Grown:
    """Run the ticks of the window, and count messages and bytes."""
    return asyncio.run(_measure(scenario))


async def _measure(scenario: Scenario) -> Grown:
    counts: Counts = Counter()
    port, robots = free_port(), scenario.robots.number
    async with bus.opened(Endpoints("router", (), (f"tcp/127.0.0.1:{port}",))) as opened, asyncio.timeout(120.0):
        server = Server(Counted(opened, counts, "beacon heard"), Run(scenario), "growth", RUN)
        agents = [asyncio.ensure_future(_live(port, robot, counts)) for robot in range(robots)]
        await server.gather()
        running = asyncio.ensure_future(server.main_loop())
        before, degrees = await _snapshot(server, FIRST, port, counts), dict[int, float]()
        while server.run.state.tick < FIRST + TICKS:
            degrees[server.run.state.tick] = _contacts(server.run.state)
            await asyncio.sleep(0.0)
        after = await _snapshot(server, FIRST + TICKS, port, counts)
        await running
        server.dismiss()
        await asyncio.gather(*agents)
    ticks = after["tick"] - before["tick"]
    spent = {what: (after[what] - before[what]) / ticks for what in after}
    return Grown(robots, sum(degrees.values()) / len(degrees), spent, spent.pop("received"), spent.pop("sent"))


async def _live(port: int, robot: int, counts: Counts) -> None:
    async with bus.opened(Endpoints("client", (f"tcp/127.0.0.1:{port}",))) as opened:
        agent = Agent(Counted(opened, counts), RUN, (robot,))
        await agent.live(await agent.join(60.0))


async def _snapshot(server: Server, tick: int, port: int, counts: Counts) -> Counts:
    while server.run.state.tick < tick:
        await asyncio.sleep(0.0)
    output = subprocess.run(["ss", "-Htin", f"sport = :{port}"], check=True, capture_output=True, text=True).stdout
    snapshot = Counter(counts)
    snapshot["tick"] = server.run.state.tick
    for what in ("received", "sent"):
        snapshot[what] = sum(int(number) for number in re.findall(rf"bytes_{what}:(\d+)", output))
    return snapshot


def _contacts(state: State) -> float:
    near = truth.observe(state).in_range
    return len(near.peers) / len(near.ids)


def standing(robots: int) -> tuple[float, float]:
    """Mean contacts of a robot at LATER, and size of the log until then [bytes per robot-tick]."""
    scenario = load(SCENARIO, {"robots.count": robots, "run.duration": LATER})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / NAME
        with Recorder(path, scenario, SCENARIO.stem, "inprocess") as recorder:
            inprocess.run(scenario, SCENARIO.stem, recorder=recorder)
        size = path.stat().st_size / (scenario.ticks * robots)
    *_, last = inprocess.ticks(scenario)
    return _contacts(last.state), size


def main() -> None:
    """Print counts beside those expected: n observations, n commands, and n beacons to k peers each."""
    print(f"growth: {SCENARIO}, ticks {FIRST} to {FIRST + TICKS}, the world as router; messages and bytes per tick")
    for robots in ROBOTS:
        measured = measure(load(SCENARIO, {"robots.count": robots, "run.duration": (FIRST + TICKS + 10) * 0.02}))
        n, k, counts = measured.robots, measured.contacts, measured.counts
        print(
            f"  {n:4d} robots, {k:5.2f} contacts: in {measured.incoming:6.1f} (2 n = {2 * n}), "
            f"out {measured.outgoing:7.1f} (n (1 + k) = {n * (1 + k):7.1f}); "
            f"bytes in {measured.received:7.0f}, out {measured.sent:7.0f}",
            flush=True,
        )
        payloads = [f"{kind} {counts[f'{kind} put, bytes'] / counts[f'{kind} put']:.0f}" for kind in KINDS]
        totals = [
            (measured.received, "beacon put", "command put"),
            (measured.sent, "beacon taken", "observation taken"),
        ]
        overheads = [
            (total - counts[f"{first}, bytes"] - counts[f"{second}, bytes"]) / (counts[first] + counts[second])
            for total, first, second in totals
        ]
        framing = "in {:.0f}, out {:.0f}".format(*overheads)
        print(f"       bytes of payload: {', '.join(payloads)}; framing of each: {framing}")
        contacts, size = standing(robots)
        print(f"       after {LATER:g} s: {contacts:.2f} contacts; log: {size:.0f} bytes per robot-tick", flush=True)


if __name__ == "__main__":
    main()
