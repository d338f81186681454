"""Restarts that the system refuses: each refusal is reported, and ends no more than necessary."""

import asyncio
import signal
from pathlib import Path

import pytest

from console.backends import process_group
from console.backends.managed_process import ManagedProcess
from console.backends.process_group import BEGUN
from console.backends.supervisor import Supervisor
from tests.support.process_groups import ENDLESS, SLOW, Impatient, family, finished, until, world


async def refused(*_: object, **__: object) -> ManagedProcess:
    raise OSError(11, "Resource temporarily unavailable")


def test_fes_run_retries_an_agent_that_cannot_be_restarted_and_reports_each_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> list[str]:
        async with family(tmp_path) as processes:
            await world(processes, SLOW, f"{BEGUN.decode()}\n")
            await processes.start_agent("0", ["--no-such-flag"])
            monkeypatch.setattr("console.backends.managed_process.start", refused)
            said: list[str] = []
            following = asyncio.ensure_future(
                Supervisor(processes, said.append, "nobody is left", Impatient()).finish()
            )
            await until((tmp_path / "here").exists)
            await until(lambda: len(said) == 4 or following.done())
            (tmp_path / "go").touch()
            assert processes.world is not None
            processes.world.signal(signal.SIGINT)
            await following
            return said

    dies, why = "fes-agent --id 0: unrecognized arguments: --no-such-flag", "Resource temporarily unavailable"
    fails = f"robot 0: fes-agent --id 0 cannot be started: {why}"
    assert asyncio.run(main()) == [
        f"robot 0: {dies}; restarted in 0.01 s",
        f"{fails}; restarted in 0.01 s",
        f"{fails}, 6 times in a row: it is not restarted; the run continues without it",
        "nobody is left",
    ]


def test_a_scheduled_robot_that_cannot_be_restarted_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> list[str]:
        async with family(tmp_path) as processes:
            await world(processes, SLOW, f"{BEGUN.decode()}\n")
            await processes.start_agent("0", [])
            await processes.kill_agent("0")
            monkeypatch.setattr("console.backends.managed_process.start", refused)
            await processes.start_agent_again("0")
            said: list[str] = []
            following = asyncio.ensure_future(Supervisor(processes, said.append).finish())
            await until(lambda: said or following.done())
            following.cancel()
            (tmp_path / "go").touch()
            return said

    why = "fes-agent --id 0 cannot be started: Resource temporarily unavailable"
    assert asyncio.run(main())[0] == f"robot 0: {why}; the run continues without it"


def test_a_world_that_cannot_be_restarted_is_reported_as_the_cause_of_the_failed_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            await world(processes, ENDLESS)
            monkeypatch.setattr("console.backends.managed_process.start", refused)
            monkeypatch.setattr(process_group, "has_checkpoint", lambda _: True)
            await processes.replace_world(0.0, [])
            return await finished(processes)

    why = "fes-world cannot be started: Resource temporarily unavailable"
    assert asyncio.run(main()) == (why, [])
