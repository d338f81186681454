"""Real robots behind a router with certificates: only an operator moves them, and each gate speaks for itself."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from console.keys import certificates
from console.team import gates, permit
from fes.errors import Rejected, TransportError, Unavailable
from fes.protocol import keys
from fes.protocol.robot_control import RUNNING, STOPPED, GateStatus, Permit, encode_permit
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.processes import PATIENCE
from tests.support.robot_table import run
from tests.support.secured_team import ROLES, RUN, Team, team

SHORT = 1.0
"""Wait for an answer that must not come [s]."""

ACTS: dict[str, Callable[[Bus, str], object]] = {
    "put": lambda who, key: who._session.put(key, encode_permit(Permit(9, 2**40, 0))),
    "declare queryable": lambda who, key: who.declare_queryable(key, lambda query: None),
    "declare subscriber": lambda who, key: who.mailbox(key),
    "liveliness token": lambda who, key: who.declare_token(key),
}
FORGERIES = [
    ("observer", "put", keys.permit(RUN)),
    ("robot-1", "put", keys.permit(RUN)),
    ("robot-1", "put", keys.robot_report(RUN, 0)),
    ("operator", "put", keys.robot_report(RUN, 0)),
    ("robot-1", "declare queryable", keys.gate_stop(RUN, 0)),
    ("robot-1", "declare queryable", keys.gate_status(RUN, "*")),
    ("observer", "declare queryable", keys.gate_start(RUN, 0)),
    ("operator", "declare queryable", keys.gate_stop(RUN, 0)),
    ("robot-1", "liveliness token", keys.gate_alive(RUN, 0)),
    ("robot-1", "declare subscriber", keys.robot_report(RUN, 0)),
]
"""Role, forbidden act and key."""


async def asked(who: Bus, key: gates.Key, robot: int, wait: float = SHORT) -> gates.Answer:
    """The answer of a gate to a query of this visitor."""
    return (await gates.ask(who, key, RUN, [robot], wait))[robot]


async def started(who: Bus, robot: int) -> gates.Answer:
    """The answer of a gate to the start of this visitor."""
    return (await gates.start(who, RUN, [robot], PATIENCE))[robot]


async def mode(on: Team, robot: int) -> str:
    """The mode of a gate, as an observer sees it."""
    async with on.visitor("observer") as observer:
        answer = await asked(observer, keys.gate_status, robot, PATIENCE)
    assert isinstance(answer, GateStatus), answer
    return answer.mode


async def moves(on: Team, robot: int, *, fast: bool = True) -> None:
    """Wait until a body has its full speed, or stands."""
    async with asyncio.timeout(PATIENCE):
        while (on.speed(robot) > 0.15) is not fast or (not fast and on.speed(robot) > 0.0):
            await asyncio.sleep(0.1)


def test_only_an_operator_starts_and_stops_robots_whose_network_has_certificates(tmp_path: Path) -> None:
    async def main() -> None:
        async with team(tmp_path) as on, on.visitor("operator") as operator:
            status = await on.person("status")
            assert (status.returncode, status.stderr) == (0, ""), status
            assert status.stdout.count("not started") == 2
            async with permit.held(operator, RUN):
                for role in ("observer", "robot-1"):
                    async with on.visitor(role) as visitor:
                        assert isinstance(await asked(visitor, keys.gate_start, 0), Unavailable)
                assert await mode(on, 0) == STOPPED
                assert gates.is_started(await started(operator, 0))
                await moves(on, 0)
                for role in ("observer", "robot-1"):
                    async with on.visitor(role) as visitor:
                        assert isinstance(await asked(visitor, keys.gate_stop, 0), Unavailable)
                assert await mode(on, 0) == RUNNING
                stopped = await on.person("stop", "--robots", "0")
                assert (stopped.returncode, stopped.stdout, stopped.stderr) == (0, "stopped: 0\n", "")
                await moves(on, 0, fast=False)
            denied = [f"{role}'s query on" for role in ("observer", "robot-1")]
            for words in denied:
                await on.logs("router", words)

    run(main)


def test_forged_permits_answers_and_tokens_are_dropped_and_logged(tmp_path: Path) -> None:
    async def main() -> None:
        async with team(tmp_path) as on:
            for role, act, key in FORGERIES:
                async with on.visitor(role) as visitor:
                    ACTS[act](visitor, key)
                    await on.logs("router", f"dropped {role}'s {act} on {key}: it has no right to it")
            async with on.visitor("operator") as operator:
                refusal = await started(operator, 0)
                assert isinstance(refusal, Rejected)  # by its own gate, which has heard none of the permits
                assert "permit" in str(refusal)

    run(main)


def test_a_second_gate_with_the_robots_own_certificate_is_refused(tmp_path: Path) -> None:
    async def main() -> None:
        async with team(tmp_path) as on:
            second = on.robot("second", 0)
            assert await asyncio.to_thread(second.wait, PATIENCE) == 1
            assert "that of robot 0 in run 'lab' is alive already" in on.log("second")
            assert await mode(on, 0) == STOPPED

    run(main)


def test_a_robot_without_a_certificate_of_this_team_does_not_join(tmp_path: Path) -> None:
    foreign = team_keys.directory(tmp_path / "foreign", certificates.create(1.0), ROLES)

    async def main() -> None:
        async with team(tmp_path) as on:
            own = team_keys.security(foreign, "operator")
            with pytest.raises(TransportError):
                async with bus.opened(Endpoints("client", (on.endpoint,), timeout=5.0, security=own)):
                    pass
            missing = on.robot("missing", 7)
            assert await asyncio.to_thread(missing.wait, PATIENCE) == 1
            assert "the robot-7 needs robot-7.crt, and there is none" in on.log("missing")
            await on.logs("router", "a connection: ")

    run(main)


def test_a_permit_of_the_operator_keeps_a_robot_moving_and_its_end_stops_it(tmp_path: Path) -> None:
    async def main() -> None:
        async with team(tmp_path) as on, on.visitor("operator") as operator:
            async with permit.held(operator, RUN):
                assert gates.is_started(await started(operator, 1))
                await moves(on, 1)
            async with asyncio.timeout(PATIENCE):
                while not gates.is_stopped(answer := await asked(operator, keys.gate_status, 1, PATIENCE)):
                    await asyncio.sleep(0.01)
            await moves(on, 1, fast=False)
            assert isinstance(answer, GateStatus)
            assert answer.reason == "the operator's permit has lapsed"
            assert on.speed(0) == 0.0

    run(main)
