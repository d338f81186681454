"""The lockstep's message pattern on bare Zenoh: one world, one asyncio process per robot, without computation.

The world sends an observation to each robot. A robot sends a beacon to its peers, then a command to the world. The
world starts the next tick after the last command. Payloads have the sizes of the real ones, and are not decoded.
With WORK [s], agents and the world spin for that long in each tick before they answer.

Run as `python -m bench.speed.bare world N TICKS ENDPOINT SIZE WORK` and
`python -m bench.speed.bare agent I ENDPOINT SIZE WORK PEER...`.
"""

import asyncio
import json
import os
import sys
import time

os.environ.setdefault(
    "ZENOH_RUNTIME",
    "(rx:(handover:app),acc:(handover:app),tx:(handover:app),net:(handover:app),app:(worker_threads:2))",
)

import zenoh
import zenoh.handlers

PROBE = b"?"


def settings(mode: str, endpoint: str) -> zenoh.Config:
    """Session settings, the same as the project's."""
    config = zenoh.Config()
    for key, value in {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "listen/endpoints": [endpoint] if mode == "router" else [],
        "connect/endpoints": [endpoint] if mode == "client" else [],
        "connect/timeout_ms": 20000,
        "transport/shared_memory/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return config


def publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    """A publisher with the project's settings."""
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=False)


def spin(seconds: float) -> None:
    """Keep the processor busy without memory access."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        pass


async def world(n: int, ticks: int, endpoint: str, size: int, work: float) -> float:
    """Ticks per second over `ticks` ticks with `n` agents."""
    loop = asyncio.get_running_loop()
    arrived: list[bytes] = []
    wanted = 0  # commands due since the start
    present: set[str] = set()
    barrier: asyncio.Future[None] = loop.create_future()

    def wake() -> None:
        if not barrier.done():
            barrier.set_result(None)

    def on_command(sample: zenoh.Sample) -> None:
        payload = sample.payload.to_bytes()
        if payload == PROBE:
            present.add(str(sample.key_expr))
            return
        arrived.append(payload)
        if len(arrived) >= wanted:
            loop.call_soon_threadsafe(wake)

    with zenoh.open(settings("router", endpoint)) as session:
        subscriber = session.declare_subscriber("bare/*/command", zenoh.handlers.Callback(on_command, indirect=False))
        puts = [publisher(session, f"bare/{robot}/observation").put for robot in range(n)]
        while len(present) < n:  # puts before a subscription exists are lost
            for put in puts:
                put(PROBE)
            await asyncio.sleep(0.05)
        payload, begun = bytes(size), 0.0
        for tick in range(ticks + 1):
            # Two threads may both call wake for one tick, the second too late: so the commands are counted again.
            while len(arrived) < wanted:
                barrier = loop.create_future()
                if len(arrived) < wanted:
                    await barrier
            if tick == 0:
                begun = time.perf_counter()
            if tick == ticks:
                break
            spin(work)
            wanted += n
            for put in puts:
                put(payload)
        rate = ticks / (time.perf_counter() - begun)
        for put in puts:
            put(b"")
        subscriber.undeclare()
    return rate


async def agent(robot: int, endpoint: str, size: int, work: float, peers: list[int]) -> None:
    """Run a robot that answers every observation until an empty one arrives."""
    loop = asyncio.get_running_loop()
    beacons: list[bytes] = []
    tick: asyncio.Future[bytes] = loop.create_future()

    def wake(payload: bytes) -> None:
        tick.set_result(payload)

    def on_observation(sample: zenoh.Sample) -> None:
        payload = sample.payload.to_bytes()
        if payload == PROBE:
            command(PROBE)
        else:
            loop.call_soon_threadsafe(wake, payload)

    def on_beacon(sample: zenoh.Sample) -> None:
        beacons.append(sample.payload.to_bytes())

    with zenoh.open(settings("client", endpoint)) as session:
        beacon = publisher(session, f"bare/{robot}/beacon").put
        command = publisher(session, f"bare/{robot}/command").put
        subscribers = [
            session.declare_subscriber(
                f"bare/{robot}/observation", zenoh.handlers.Callback(on_observation, indirect=False)
            )
        ]
        for peer in peers:
            subscribers.append(
                session.declare_subscriber(f"bare/{peer}/beacon", zenoh.handlers.Callback(on_beacon, indirect=False))
            )
        payload = bytes(size)
        while await tick:
            tick = loop.create_future()
            beacons.clear()
            spin(work)
            beacon(payload)
            command(payload)
        for subscriber in subscribers:
            subscriber.undeclare()


def main() -> None:
    """Run one of the two roles."""
    role, *words = sys.argv[1:]
    if role == "world":
        n, ticks, endpoint, size, work = words
        print(asyncio.run(world(int(n), int(ticks), endpoint, int(size), float(work))), flush=True)
    else:
        robot, endpoint, size, work, *peers = words
        asyncio.run(agent(int(robot), endpoint, int(size), float(work), [int(peer) for peer in peers]))
    os._exit(0)


if __name__ == "__main__":
    main()
