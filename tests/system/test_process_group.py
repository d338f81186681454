"""Children of `fes run`: a world has the time that it needs to close, and an agent that dies does not end the run."""

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


def test_a_world_that_is_slow_to_write_what_was_reached_is_not_ended_as_soon_as_its_agents_are_gone(
    tmp_path: Path,
) -> None:
    async def main() -> None:
        async with family(tmp_path) as kin:
            await world(kin, SLOW)
            await until((tmp_path / "here").exists)
            asyncio.get_running_loop().call_later(2 * process_group.DISMISSAL, (tmp_path / "go").touch)

    asyncio.run(main())
    assert (tmp_path / "kept").exists()


def test_robots_that_a_scenario_killed_are_not_blamed_for_what_the_world_says(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as kin:
            for robot in "01":
                await agent(kin, robot, ENDLESS)
                await kin.kill_agent(robot)
            await world(kin, FAILURE, "fes-world: error: no room\n")
            return await finished(kin)

    assert asyncio.run(main()) == ("fes-world: no room", [])


def test_a_run_whose_scenario_kills_a_world_without_a_checkpoint_is_over(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as kin:
            await world(kin, ENDLESS)
            await kin.replace_world(1000.0, [])
            return await finished(kin)

    assert asyncio.run(main()) == ("", [])


def test_an_agent_that_dies_while_its_world_goes_on_is_named_and_ends_nothing(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as kin:
            await world(kin, SLOW, f"{BEGUN.decode()}\n")
            await (await agent(kin, "5", SUCCESS, "2026 agent.5: the run is over\n")).process.wait()
            for robots in ("0", "1-2"):
                (await agent(kin, robots, ENDLESS)).process.kill()
            await agent(kin, "3", FAILURE, "Traceback\nValueError: \x1b[2Jodd\n")
            await agent(kin, "4", SUCCESS, "2026 agent.4: ready\n")
            following = asyncio.ensure_future(finished(kin))
            await until((tmp_path / "here").exists)
            await until(lambda: kin.is_deserted)
            (tmp_path / "go").touch()
            assert kin.world is not None
            kin.world.signal(signal.SIGINT)
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


def test_an_agent_that_ends_before_the_run_begins_is_what_it_fails_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as kin:
            await world(kin, ENDLESS, "waiting for 2 robots\n")
            await agent(kin, "1", FAILURE, "fes-agent: error: gave up\n")
            return await finished(kin)

    monkeypatch.setattr(supervisor, "SETTLING", 0.1)
    assert asyncio.run(main()) == ("fes-agent --id 1: gave up; the run cannot begin without it", [])


def test_one_that_is_started_again_may_end_before_the_run_begins(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as kin:
            await world(kin, SLOW, "waiting for 2 robots\n")
            await kin.start_agent("0", ["--no-such-flag"])
            following = asyncio.ensure_future(finished(kin, Tireless()))
            await until(lambda: len(kin.agents) > 1)
            (tmp_path / "go").touch()
            await until((tmp_path / "here").exists)
            assert kin.world is not None
            kin.world.signal(signal.SIGINT)
            return await following

    failed, said = asyncio.run(main())
    assert failed == ""
    assert said[0] == "robot 0: fes-agent --id 0: unrecognized arguments: --no-such-flag; started again in 0.01 s"


def test_a_world_that_fails_is_named_before_the_agents_that_fail_with_it(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str]]:
        async with family(tmp_path) as kin:
            fails_last = "import sys; sys.stdin.readline(); raise SystemExit(1)"
            await world(kin, fails_last, "fes-world: error: the address is taken\n")
            failed = await agent(kin, "1", FAILURE, "fes-agent: error: gave up\n")
            following = asyncio.ensure_future(finished(kin))
            await failed.process.wait()
            await until(kin.ends.empty)  # the end of the agent has been taken up
            assert kin.world is not None
            assert kin.world.process.stdin is not None
            kin.world.process.stdin.write(b"\n")
            return await following

    assert asyncio.run(main()) == ("fes-world: the address is taken", [])


def test_an_agent_that_dies_each_time_is_started_again_a_few_times_and_then_given_up(tmp_path: Path) -> None:
    async def main() -> tuple[str, list[str], int]:
        async with family(tmp_path) as kin:
            await world(kin, SLOW, f"{BEGUN.decode()}\n")
            await kin.start_agent("0", ["--no-such-flag"])
            following = asyncio.ensure_future(finished(kin, Impatient()))
            await until((tmp_path / "here").exists)
            await until(lambda: len(kin.agents) == 3 and kin.is_deserted)
            (tmp_path / "go").touch()
            assert kin.world is not None
            kin.world.signal(signal.SIGINT)
            return *await following, len(kin.agents)

    failed, said, started = asyncio.run(main())
    why = "robot 0: fes-agent --id 0: unrecognized arguments: --no-such-flag"
    assert (failed, started) == ("", 3)
    assert said[:2] == [f"{why}; started again in 0.01 s"] * 2
    assert said[2].startswith(f"{why}, 6 times in a row: it is not started again")
    assert said[3] == "nobody is left"


def test_no_agent_that_waits_to_be_started_again_is_started_when_all_ends(tmp_path: Path) -> None:
    async def main() -> list[ManagedProcess]:
        async with family(tmp_path) as kin:
            await world(kin, SLOW)
            await kin.start_agent("0", ["--no-such-flag"])
            await kin.agents[0].process.wait()
            await until((tmp_path / "here").exists)
            kin.restart_agent("0", 0.1)
            asyncio.get_running_loop().call_later(0.5, (tmp_path / "go").touch)  # it closes for longer than that
        return kin.agents

    assert len(asyncio.run(main())) == 1


def test_an_agent_that_is_stopped_at_the_end_is_told_to_end_and_not_killed(tmp_path: Path) -> None:
    """It would wait for a world that is over; once continued, it ends as it was told to."""

    async def main() -> ManagedProcess:
        async with family(tmp_path) as kin:
            (tmp_path / "go").touch()
            stopped = await agent(kin, "0", SLOW)
            await until((tmp_path / "here").exists)
            stopped.signal(signal.SIGSTOP)
            await world(kin, SUCCESS)
            assert await finished(kin) == ("", [])
        return stopped

    stopped = asyncio.run(main())
    assert stopped.process.returncode == 0
    assert not alive(stopped.process.pid)
    assert (tmp_path / "kept").exists()
