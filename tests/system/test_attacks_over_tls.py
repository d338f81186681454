"""A run over TLS under attack, with real certificates: each attack is rejected, and logged once.

These attacks come before the run; those of test_forgeries.py come on every tick, with well-formed payloads.
"""

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from console.backends import inprocess
from console.backends.process_group import free_port
from console.doctor import network
from console.doctor.finding import Status
from console.keys import certificates
from fes.errors import TransportError, Unavailable
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ParameterChange
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.loop import load
from tests.support.processes import PATIENCE, until
from tests.support.stage import ROLES, RUN, SECONDS, Stage, stage
from world.server.audit import KINDS_PER_NAME


@pytest.fixture(scope="module")
def issuer() -> certificates.Authority:
    return certificates.create(1.0)


@pytest.fixture
def expected() -> str:
    return str(inprocess.run(load("pair.toml", run__duration=SECONDS), "pair")["digest"])


ACTS: dict[str, Callable[[Bus, str], object]] = {
    "put": lambda who, key: who._session.put(key, b"x"),
    "delete": lambda who, key: who._session.delete(key),
    "liveliness token": lambda who, key: who.declare_token(key),
    "declare subscriber": lambda who, key: who.mailbox(key),
    "declare queryable": lambda who, key: who.declare_queryable(key, lambda query: None),
}
FORGERIES = [
    ("robot-1", "put", keys.beacon(RUN, 0)),
    ("robot-1", "put", keys.command(RUN, 0)),
    ("robot-1", "put", keys.command(RUN, "*")),
    ("robot-1", "put", keys.observation(RUN, 0)),
    ("robot-1", "put", keys.observation(RUN, 1)),
    ("robot-1", "put", keys.report(RUN)),
    ("robot-1", "delete", keys.command(RUN, 0)),
    ("robot-1", "liveliness token", keys.robot_alive(RUN, 0)),
    ("robot-1", "liveliness token", keys.world_alive(RUN)),
    ("robot-1", "declare subscriber", keys.observation(RUN, 0)),
    ("robot-1", "declare subscriber", keys.report(RUN)),
    ("robot-1", "declare subscriber", keys.tree(RUN)),
    ("robot-1", "declare queryable", keys.welcome(RUN, "0")),
    ("observer", "put", keys.command(RUN, 0)),
    ("observer", "put", keys.report(RUN)),
    ("observer", "declare subscriber", keys.beacon(RUN, 0)),
    ("operator", "put", keys.command(RUN, 0)),
]
"""Forbidden operations: role, operation, key expression."""


def test_each_forgery_is_rejected_and_logged_once_and_the_run_is_the_same(
    tmp_path: Path, expected: str, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)

    async def main() -> Stage:
        async with stage(tmp_path, keyed) as world, contextlib.AsyncExitStack() as visitors:
            world.agent(1)
            who = {role: await visitors.enter_async_context(world.visitor(role)) for role in ROLES[2:]}
            for role, act, key in FORGERIES:
                ACTS[act](who[role], key)
            for role, key in (("observer", keys.change(RUN)), ("robot-1", keys.welcome(RUN, "0"))):
                query = channel_change.encode_change(ParameterChange("channel.reference_snr", 1.0))
                with pytest.raises(Unavailable):
                    await who[role].get(key, query, 1.0)
            while world.log().count("it has no right to it") < len(FORGERIES) + 2:
                await asyncio.sleep(0.02)
            assert "all robots are here" not in world.log()  # robot 0's token was forged, and is not forwarded
            world.agent(0)
            assert await world.over(), world.log()
            return world

    world = asyncio.run(main())
    assert world.digest() == expected
    log = world.log()
    asked = [("observer", "query", keys.change(RUN)), ("robot-1", "query", keys.welcome(RUN, "0"))]
    for role, act, key in [*FORGERIES, *asked]:
        assert log.count(f"dropped {role}'s {act} on {key}: it has no right to it") == 1, (role, act, key, log)
    assert log.count("it has no right to it") == len(FORGERIES) + 2, log


def test_a_client_that_invents_keys_hides_no_other_client(tmp_path: Path, issuer: certificates.Authority) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)
    acts = [
        ("put", keys.command(RUN, 0)),
        ("put", keys.observation(RUN, 0)),
        ("liveliness token", keys.robot_alive(RUN, 0)),
    ]

    async def main() -> str:
        async with stage(tmp_path, keyed) as world, world.visitor("observer") as vandal:
            for number in range(150):
                vandal._session.put(f"{RUN}/made/up/{number}", b"x")
            await asyncio.to_thread(until, lambda: "(further kinds are counted" in world.log())
            async with world.visitor("operator") as forger:
                for act, key in acts:
                    ACTS[act](forger, key)
                await asyncio.to_thread(until, lambda: world.log().count("operator's") == len(acts))
            return world.log()

    log = asyncio.run(main())
    assert all(f"dropped operator's {act} on {key}: it has no right to it" in log for act, key in acts)
    assert log.count("dropped observer's") == KINDS_PER_NAME + 1


def test_robots_observers_and_operators_have_the_rights_of_their_roles(
    tmp_path: Path, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)

    async def main() -> Stage:
        async with stage(tmp_path, keyed) as world, world.visitor("observer") as observer:
            seen: list[str] = []
            observer.declare_liveliness_subscriber(keys.robot_alive(RUN, "*"), lambda key, alive: seen.append(key))
            reports = observer.mailbox(keys.report(RUN))
            looking = Endpoints("client", (world.endpoint,), security=team_keys.security(keyed, "observer"))
            findings, robots = await network.examine(looking, RUN, True)
            others = [result.check for result in findings if result.status is not Status.OK]
            assert (robots, others) == (2, ["alive"])  # both robots have not joined yet
            world.agent(0)
            world.agent(1)
            while (report := reports.take()) is None:
                await asyncio.sleep(0.02)
            assert report[0] == keys.report(RUN)
            assert set(seen) == {keys.robot_alive(RUN, 0), keys.robot_alive(RUN, 1)}
            async with world.visitor("operator") as operator:
                query = channel_change.encode_change(ParameterChange("channel.reference_snr", 5e6))
                effect = channel_change.decode_result(await operator.get(keys.change(RUN), query, PATIENCE))
                assert effect.value == 5e6
            assert await world.over(), world.log()
            return world

    assert asyncio.run(main()).log().count("dropped") == 0


def test_a_certificate_of_another_run_opens_no_session(
    tmp_path: Path, expected: str, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)
    other = certificates.create(1.0)
    bad = tmp_path / "bad"
    team_keys.write(bad, "ca", issuer.pem)
    team_keys.write(bad, "other", certificates.issue(other, "robot-0", 1.0))
    team_keys.write(bad, "itself", other.pem)
    team_keys.write(bad, "expired", certificates.issue(issuer, "robot-0", -1.0))
    naked = team_keys.security(keyed, "robot-0")
    naked = {**naked, "transport/link/tls": {"root_ca_certificate": str(keyed / "ca.crt"), "enable_mtls": False}}
    elsewhere = team_keys.directory(tmp_path / "elsewhere", other, ["robot-0"])

    async def main() -> Stage:
        async with stage(tmp_path, keyed) as world:
            plain = world.endpoint.replace("tls/", "tcp/")
            attempts: list[tuple[str, dict[str, object], str]] = [
                (world.endpoint, team_keys.security(bad, "other"), "it refuses our certificate"),
                (world.endpoint, team_keys.security(bad, "itself"), "it refuses our certificate"),
                (
                    world.endpoint,
                    team_keys.security(bad, "expired"),
                    "it refuses our certificate: certificate expired",
                ),
                (world.endpoint, naked, "it refuses our certificate: certificate required"),
                (world.endpoint, team_keys.security(elsewhere, "robot-0"), "its certificate is not to be trusted"),
                (plain, {}, "a process listens there, but opens no session"),
            ]
            for endpoint, own, complaint in attempts:
                with pytest.raises(TransportError) as caught:
                    async with bus.opened(Endpoints("client", (endpoint,), timeout=0.5, security=own)):
                        pass
                assert str(caught.value).startswith(f"cannot join the network at {endpoint}: {complaint}")
            world.agent(0)
            world.agent(1)
            assert await world.over(), world.log()
            return world

    world = asyncio.run(main())
    assert world.digest() == expected
    for why in (
        "its certificate is not of this run's authority",
        "its certificate has expired",
        "it has no certificate",
        "it does not trust the world's certificate",
        "it does not speak TLS",
    ):
        assert world.log().count(f"dropped a connection: {why}") == 1, (why, world.log())


def test_a_robot_cannot_impersonate_the_world(tmp_path: Path, issuer: certificates.Authority) -> None:
    """Its certificate is not valid for a server, and a robot connects to no other."""
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)
    own = team_keys.security(keyed, "robot-1")
    tls = own["transport/link/tls"]
    assert isinstance(tls, dict)
    served = {"listen_certificate": tls["connect_certificate"], "listen_private_key": tls["connect_private_key"]}

    async def main() -> None:
        endpoint = f"tls/127.0.0.1:{free_port()}"
        imposter = Endpoints("router", (), (endpoint,), security={**own, "transport/link/tls": {**tls, **served}})
        async with bus.opened(imposter):
            with pytest.raises(TransportError, match="its certificate is not to be trusted"):
                async with bus.opened(
                    Endpoints("client", (endpoint,), timeout=0.5, security=team_keys.security(keyed, "robot-0"))
                ):
                    pass

    asyncio.run(main())


def test_a_client_with_the_session_id_of_a_robot_does_not_get_its_rights(
    tmp_path: Path, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)

    async def main() -> str:
        async with stage(tmp_path, keyed) as world:
            stolen = team_keys.security(keyed, "robot-1")
            async with world.visitor("robot-0") as robot:
                same = (f'id:"{robot._session.info.zid()}"',)
                endpoints = Endpoints("client", (world.endpoint,), (), None, same, 0.5, security=stolen)
                with pytest.raises(TransportError):
                    async with bus.opened(endpoints):
                        pass
            # The robot has left: its session id is free.
            async with bus.opened(replace(endpoints, timeout=PATIENCE)) as thief:
                thief._session.put(keys.command(RUN, 0), b"x")
                refused = "dropped robot-1's put on fes/main/robot/0/command"
                await asyncio.to_thread(until, lambda: refused in world.log())
            return world.log()

    assert "robot-0's" not in asyncio.run(main())
