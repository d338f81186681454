"""Children of `fes run`: who is told to stop is given the time that it takes."""

import asyncio
import subprocess
import sys
from pathlib import Path

from console import launcher
from console.launcher import Child

SLOW = """
import asyncio, os, sys
from pathlib import Path
from fes import process

async def main():
    Path("here").touch()
    try:
        await asyncio.sleep(1000.0)
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
