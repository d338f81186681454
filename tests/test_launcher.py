"""Children of `fes run`: who is told to stop is given the time that it takes, and who failed is named."""

import asyncio
import subprocess
import sys
from pathlib import Path

import pytest

from console import launcher
from console.launcher import Child, ChildFailed, Family

SLOW = """
import asyncio, os, sys
from pathlib import Path
from fes import process

async def main():
    Path("here").touch()
    try:
        await asyncio.Event().wait()
    finally:
        while not Path("go").exists():
            await asyncio.sleep(0.01)
        Path("kept").touch()
    return 0

process.run("slow", main, exit_with_stdin=True)
"""
"""A world that writes down what was reached when it is let."""


def test_a_world_that_is_slow_to_write_what_was_reached_is_not_ended_as_soon_as_its_agents_are_gone(
    tmp_path: Path,
) -> None:
    async def main() -> None:
        async with launcher.family(tmp_path) as kin:
            words = [sys.executable, "-c", SLOW]
            started = await asyncio.create_subprocess_exec(
                *words, cwd=tmp_path, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
            kin.world = Child("fes-world", started, tmp_path / "world.log")
            while not (tmp_path / "here").exists():
                await asyncio.sleep(0.01)
            asyncio.get_running_loop().call_later(launcher.DISMISSAL, (tmp_path / "go").touch)

    asyncio.run(main())
    assert (tmp_path / "kept").exists()


ENDLESS = "import signal; signal.pause()"


async def child(where: Path, name: str, code: str, said: str = "") -> Child:
    """A process in place of a program; `said` is in its log."""
    log = where / f"{name}.log"
    log.write_text(said)
    started = await asyncio.create_subprocess_exec(sys.executable, "-c", code, stdin=subprocess.DEVNULL)
    return Child(name, started, log)


async def blamed(kin: Family) -> str:
    """What a run is said to have failed of."""
    with pytest.raises(ChildFailed) as caught:
        await kin.finish()
    return str(caught.value)


def test_robots_that_a_scenario_killed_are_not_blamed_for_what_the_world_says(tmp_path: Path) -> None:
    async def main() -> str:
        async with launcher.family(tmp_path) as kin:
            for robot in (0, 1):
                kin.agents.append(await child(tmp_path, f"fes-agent --id {robot}", ENDLESS))
                await kin.kill_agent(str(robot))
            kin.world = await child(tmp_path, "fes-world", "raise SystemExit(1)", "fes-world: error: no room\n")
            return await blamed(kin)

    assert asyncio.run(main()) == "no room"


def test_a_world_that_a_scenario_killed_is_not_blamed_for_an_agent_that_fails(tmp_path: Path) -> None:
    async def main() -> str:
        async with launcher.family(tmp_path) as kin:
            kin.world = await child(tmp_path, "fes-world", ENDLESS)
            await kin.replace_world(1000.0, [])  # without a checkpoint nobody follows
            kin.agents.append(
                await child(tmp_path, "fes-agent --id 0", "raise SystemExit(1)", "fes-agent: error: gave up\n")
            )
            return await blamed(kin)

    assert asyncio.run(main()) == "gave up"


def test_whoever_else_was_ended_by_force_is_named_before_what_the_world_says(tmp_path: Path) -> None:
    async def main() -> str:
        async with launcher.family(tmp_path) as kin:
            kin.world = await child(tmp_path, "fes-world", "raise SystemExit(1)", "fes-world: error: it left\n")
            for robot in (0, 1):
                kin.agents.append(await child(tmp_path, f"fes-agent --id {robot}", ENDLESS))
            await kin.kill_agent("0")
            kin.agents[1].process.kill()
            return await blamed(kin)

    log = tmp_path / "fes-agent --id 1.log"
    assert asyncio.run(main()) == f"fes-agent --id 1 was ended by SIGKILL (its log: {log}); the world: it left"
