"""Children of `fes run`: a world has enough time to close, and an agent that dies does not end the run."""

import asyncio
import signal
from pathlib import Path

import pytest

from console.backends import process_group, supervisor
from console.backends.managed_process import ManagedProcess
from console.backends.process_group import BEGUN
from tests.support.process_groups import (
    ENDLESS,
    FAILURE,
    SLOW,
    SUCCESS,
    Impatient,
    Tireless,
    agent,
    family,
    finished,
    until,
    world,
)
from tests.support.processes import alive


def test_a_world_that_is_slow_to_write_its_results_is_not_killed_when_its_agents_end(
    tmp_path: Path,
) -> None:
    async def main() -> None:
        async with family(tmp_path) as processes:
            await world(processes, SLOW)
            await until((tmp_path / "here").exists)
            asyncio.get_running_loop().call_later(2 * process_group.DISMISSAL, (tmp_path / "go").touch)

    asyncio.run(main())
    assert (tmp_path / "kept").exists()


def test_robots_killed_by_the_scenario_are_not_reported_as_the_cause_of_a_failure(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            for robot in "01":
                await agent(processes, robot, ENDLESS)
                await processes.kill_agent(robot)
            await world(processes, FAILURE, "fes-world: error: no room\n")
            return await finished(processes)

    assert asyncio.run(main()) == ("fes-world: no room", [])


def test_a_run_whose_scenario_kills_a_world_without_a_checkpoint_is_over(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            await world(processes, ENDLESS)
            await processes.replace_world(1000.0, [])
            return await finished(processes)

    assert asyncio.run(main()) == ("", [])


def test_an_agent_that_dies_is_named_and_its_world_continues(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            await world(processes, SLOW, f"{BEGUN.decode()}\n")
            await (await agent(processes, "5", SUCCESS, "2026 agent.5: the run is over\n")).process.wait()
            for robots in ("0", "1-2"):
                (await agent(processes, robots, ENDLESS)).process.kill()
            await agent(processes, "3", FAILURE, "Traceback\nValueError: \x1b[2Jodd\n")
            await agent(processes, "4", SUCCESS, "2026 agent.4: ready\n")
            following = asyncio.ensure_future(finished(processes))
            await until((tmp_path / "here").exists)
            await until(lambda: processes.is_abandoned)
            (tmp_path / "go").touch()
            assert processes.world is not None
            processes.world.signal(signal.SIGINT)
            return await following

    failed, said = asyncio.run(main())
    logs = [f"its log: {tmp_path / f'fes-agent --id {robots}.log'}" for robots in ("0", "1-2", "3", "4")]
    assert failed == ""
    assert said.pop() == "nobody is left"
    assert sorted(said) == [
        f"robot 0: fes-agent --id 0 was ended by SIGKILL ({logs[0]}); the run continues without it",
        f"robot 3: fes-agent --id 3 ended with exit code 1, ValueError: \\x1b[2Jodd ({logs[2]}); "
        "the run continues without it",
        f"robot 4: fes-agent --id 4 ended with exit code 0 ({logs[3]}); the run continues without it",
        f"robots 1-2: fes-agent --id 1-2 was ended by SIGKILL ({logs[1]}); the run continues without them",
    ]


def test_an_agent_that_ends_before_the_run_begins_is_reported_as_the_cause_of_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            await world(processes, ENDLESS, "waiting for 2 robots\n")
            await agent(processes, "1", FAILURE, "fes-agent: error: timed out\n")
            return await finished(processes)

    monkeypatch.setattr(supervisor, "SETTLING", 0.1)
    assert asyncio.run(main()) == ("fes-agent --id 1: timed out; the run cannot begin without it", [])


def test_a_restarted_agent_may_end_before_the_run_begins(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            await world(processes, SLOW, "waiting for 2 robots\n")
            await processes.start_agent("0", ["--no-such-flag"])
            following = asyncio.ensure_future(finished(processes, Tireless()))
            await until(lambda: len(processes.agents) > 1)
            (tmp_path / "go").touch()
            await until((tmp_path / "here").exists)
            assert processes.world is not None
            processes.world.signal(signal.SIGINT)
            return await following

    failed, said = asyncio.run(main())
    assert failed == ""
    assert said[0] == "robot 0: fes-agent --id 0: unrecognized arguments: --no-such-flag; restarted in 0.01 s"


def test_a_failed_world_is_named_before_the_agents_that_fail_with_it(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as processes:
            fails_last = "import sys; sys.stdin.readline(); raise SystemExit(1)"
            await world(processes, fails_last, "fes-world: error: the address is taken\n")
            failed = await agent(processes, "1", FAILURE, "fes-agent: error: timed out\n")
            following = asyncio.ensure_future(finished(processes))
            await failed.process.wait()
            await until(processes.ends.empty)  # the end of the agent was handled
            assert processes.world is not None
            assert processes.world.process.stdin is not None
            processes.world.process.stdin.write(b"\n")
            return await following

    assert asyncio.run(main()) == ("fes-world: the address is taken", [])


def test_an_agent_that_dies_repeatedly_is_restarted_only_a_few_times(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str], int]:
        async with family(tmp_path) as processes:
            await world(processes, SLOW, f"{BEGUN.decode()}\n")
            await processes.start_agent("0", ["--no-such-flag"])
            following = asyncio.ensure_future(finished(processes, Impatient()))
            await until((tmp_path / "here").exists)
            await until(lambda: len(processes.agents) == 3 and processes.is_abandoned)
            (tmp_path / "go").touch()
            assert processes.world is not None
            processes.world.signal(signal.SIGINT)
            return *await following, len(processes.agents)

    failed, said, started = asyncio.run(main())
    why = "robot 0: fes-agent --id 0: unrecognized arguments: --no-such-flag"
    assert (failed, started) == ("", 3)
    assert said[:2] == [f"{why}; restarted in 0.01 s"] * 2
    assert said[2].startswith(f"{why}, 6 times in a row: it is not restarted")
    assert said[3] == "nobody is left"


def test_no_agent_is_restarted_while_the_run_ends(tmp_path: Path) -> None:
    async def main() -> list[ManagedProcess]:
        async with family(tmp_path) as processes:
            await world(processes, SLOW)
            await processes.start_agent("0", ["--no-such-flag"])
            await processes.agents[0].process.wait()
            await until((tmp_path / "here").exists)
            processes.restart_agent("0", 0.1)
            asyncio.get_running_loop().call_later(0.5, (tmp_path / "go").touch)  # it closes for longer than that
        return processes.agents

    assert len(asyncio.run(main())) == 1


def test_an_agent_that_is_suspended_at_the_end_is_terminated_and_not_killed(tmp_path: Path) -> None:
    """A suspended agent would wait for its ended world; once continued, it obeys SIGTERM."""

    async def main() -> ManagedProcess:
        async with family(tmp_path) as processes:
            (tmp_path / "go").touch()
            stopped = await agent(processes, "0", SLOW)
            await until((tmp_path / "here").exists)
            stopped.signal(signal.SIGSTOP)
            await world(processes, SUCCESS)
            assert await finished(processes) == ("", [])
        return stopped

    stopped = asyncio.run(main())
    assert stopped.process.returncode == 0
    assert not alive(stopped.process.pid)
    assert (tmp_path / "kept").exists()
