"""The world repeats a beacon that did not arrive: the copy by which it judged the sender."""

import asyncio
import contextlib

import pytest

from agents.runtime.beacon_subscriptions import BeaconSubscriptions
from console.backends import inprocess
from fes.errors import Rejected, Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN, client
from world.execution.run import Run
from world.server.server import Server


def deaf_at_tick_40(monkeypatch: pytest.MonkeyPatch) -> None:
    heard, payloads = BeaconSubscriptions.heard, BeaconSubscriptions.payloads

    def hear(radio: BeaconSubscriptions, tick: int) -> list[Beacon]:
        return [beacon for beacon in heard(radio, tick) if tick != 40]

    def take(radio: BeaconSubscriptions, tick: int) -> list[bytes]:
        return [payload for payload in payloads(radio, tick) if tick != 40]

    monkeypatch.setattr(BeaconSubscriptions, "heard", hear)
    monkeypatch.setattr(BeaconSubscriptions, "payloads", take)


def test_a_beacon_that_does_not_arrive_is_recalled(monkeypatch: pytest.MonkeyPatch) -> None:
    paper = load("paper.toml", run__duration=1.5)
    deaf_at_tick_40(monkeypatch)
    summary, _, agents = asyncio.run(session.run(paper, [[0, 1, 2], [3], [4, 5, 6, 7, 8, 9]]))
    assert summary["digest"] == inprocess.run(paper, "test")["digest"]
    assert all(agent.drops.counts["Beacon: recalled"] for agent in agents)


def test_a_beacon_that_cannot_be_recalled_is_an_error_instead_of_a_wrong_digest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    deaf_at_tick_40(monkeypatch)
    monkeypatch.setattr("world.execution.run.RECALLABLE", 0)
    monkeypatch.setattr("world.server.lockstep.RETURN_TIMEOUT", 1.0)
    near = load("pair.toml", channel__model="perfect", run__duration=1.0)

    async def main() -> None:
        async with session.router() as (opened, endpoint):
            server = Server(opened, Run(near), "test", RUN)
            agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
            await server.gather()
            with pytest.raises(Unavailable, match=r"^no robot is reachable: the world waited 1 s at tick 42$"):
                await asyncio.wait_for(server.main_loop(), PATIENCE)
            for agent in agents:
                with pytest.raises(Unavailable, match=r"a beacon that decoded did not arrive at tick 41"):
                    await asyncio.wait_for(agent, PATIENCE)

    asyncio.run(main())


def test_the_world_resends_a_beacon_as_its_peers_received_it_even_without_a_log() -> None:
    repeated: list[bool] = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as robot:
            beacons = robot.mailbox(keys.beacon(RUN, 1))
            await robot.get(keys.about(RUN), b"", PATIENCE)
            begin.set()
            while not repeated:
                sample = beacons.take()
                if sample is None or sample[1] is None:
                    await asyncio.sleep(0)
                    continue
                query = messages.encode_recall(messages.decode_beacon(sample[1]).tick)
                with contextlib.suppress(Rejected):  # not judged yet, or deleted already
                    repeated.append(await robot.get(keys.held_beacon(RUN, 1, "0"), query, PATIENCE) == sample[1])

    asyncio.run(session.run(load("pair.toml", run__duration=20.0), [[0], [1]], disturb))
    assert repeated == [True]


@pytest.mark.parametrize(("robot", "tick"), [(1, 10**6), (77, 0), ("x", 0)])
def test_the_world_refuses_to_repeat_a_beacon_that_it_does_not_hold(robot: int | str, tick: int) -> None:
    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as opened:
            rule = f"^the world holds no beacon of robot {robot} from tick {tick}$"
            with pytest.raises(Rejected, match=rule):
                await opened.get(keys.held_beacon(RUN, robot, "0"), messages.encode_recall(tick), PATIENCE)

    asyncio.run(session.run(load("pair.toml", run__duration=0.2), [[0], [1]], disturb))
