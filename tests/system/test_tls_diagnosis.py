"""Errors of programs that cannot take part over TLS: they name the certificate if it is the cause."""

import asyncio
from pathlib import Path

import pytest

from console.doctor import network
from console.keys import certificates
from fes.protocol import keys
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.processes import PATIENCE, command, start
from tests.support.stage import ROLES, RUN, Stage, stage


@pytest.fixture(scope="module")
def issuer() -> certificates.Authority:
    return certificates.create(1.0)


async def said(world: Stage, robots: str, timeout: float, *flags: str) -> str:
    """Last line of an agent that cannot join."""
    words = ("--id", robots, "-e", world.endpoint, "--timeout", str(timeout), *flags)
    agent = start(command("agents.process", *words), world.where)
    world.running.append(agent)
    _, lines = await asyncio.to_thread(agent.communicate)
    assert agent.returncode == 1, lines
    return str(lines.splitlines()[-1])


@pytest.mark.parametrize("robots", ["7", "0-1"])
def test_an_agent_without_a_role_in_the_run_names_the_log_to_read(
    tmp_path: Path, issuer: certificates.Authority, robots: str
) -> None:
    """Robot 7 of a run of two, and a crew with a certificate issued after the start of the world."""
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)

    async def main() -> tuple[str, Stage]:
        async with stage(tmp_path, keyed) as world:
            team_keys.directory(keyed, issuer, [f"robot-{robots}"])
            return await said(world, robots, 10.0, *world.flags), world

    line, world = asyncio.run(main())
    assert line == (
        f"fes-agent: error: no world of run 'main' appeared within 10 s: {world.endpoint} accepts our certificate; "
        f"a world there logs whether its run has no role 'robot-{robots}'"
    )
    assert "no role of this run has its certificate's name" in world.log()


def test_an_agent_whose_certificate_expires_during_a_world_restart_reports_it(
    tmp_path: Path, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)

    async def main() -> str:
        async with stage(tmp_path, keyed) as world:
            ending = asyncio.ensure_future(said(world, "0", 10.0, *world.flags))
            async with world.visitor("observer") as observer:
                while keys.robot_alive(RUN, 0) not in await observer.liveliness_get(keys.tree(RUN), PATIENCE):
                    await asyncio.sleep(0.02)
            team_keys.write(keyed, "robot-0", certificates.issue(issuer, "robot-0", -1.0))
            world.running[0].kill()
            return await ending

    line = asyncio.run(main())
    assert line.startswith("fes-agent: error: the world of run 'main' left after tick -1: ")
    assert f"{keyed}/robot-0.crt: the certificate expired on " in line


def test_an_agent_without_certificates_ends_with_advice_on_keys(
    tmp_path: Path, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)

    async def main() -> None:
        async with stage(tmp_path, keyed) as world:
            wanted = "it asks for a certificate, and we have none: a world with --keys wants --keys"
            line = await said(world, "0", 1.0)
            assert line == f"fes-agent: error: cannot join the network at {world.endpoint}: {wanted}"
            for endpoint in (world.endpoint, world.endpoint.replace("tls/", "tcp/")):
                [findings], _ = await network.examine(Endpoints("client", (endpoint,), timeout=0.5), RUN, True)
                assert "--keys" in findings.seen
                assert findings.remedy.startswith("fes doctor -e tls/HOST:PORT --keys DIR")

    asyncio.run(main())


def test_an_agent_with_certificates_of_another_authority_ends_with_advice_on_them(
    tmp_path: Path, issuer: certificates.Authority
) -> None:
    keyed = team_keys.directory(tmp_path / "keys", issuer, ROLES)
    other = team_keys.directory(tmp_path / "other", certificates.create(1.0), ["observer"])

    async def main() -> None:
        async with stage(tmp_path, keyed) as world:
            own = team_keys.security(other, "observer")
            foreign = Endpoints("client", (world.endpoint,), timeout=0.5, security=own)
            [findings], _ = await network.examine(foreign, RUN, True)
            assert "its certificate is not to be trusted" in findings.seen
            assert "of the world's authority" in findings.remedy

    asyncio.run(main())
