"""One child of `fes run`: the signals that meet it while it starts, and the report of its end."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from console.backends.managed_process import ManagedProcess
from tests.support.process_groups import FAILURE, child, family


def test_a_signal_to_an_interpreter_that_is_starting_waits_for_its_handler(tmp_path: Path) -> None:
    """Before it is set, Python would die of the signal, or print a traceback of its own start."""

    async def main() -> ManagedProcess:
        async with family(tmp_path) as processes:
            await processes.start_agent("0", [])
            processes.agents[0].signal(signal.SIGINT)
            async with asyncio.timeout(60.0):
                await processes.agents[0].process.wait()
        return processes.agents[0]

    ended = asyncio.run(main())
    assert (ended.process.returncode, ended.log.read_text()) == (0, "")


@pytest.mark.parametrize("log", ["missing", "a folder", "within a file", "unreadable"])
def test_the_verdict_on_a_child_names_it_even_without_its_log(tmp_path: Path, log: str) -> None:
    async def main() -> tuple[str, bool]:
        process = await child(tmp_path, "fes-world", FAILURE, "fes-world: error: no room\n")
        await process.process.wait()
        if log in ("missing", "a folder"):
            process.log.unlink()
        if log == "a folder":
            process.log.mkdir()
        if log == "within a file":
            process = ManagedProcess(process.name, process.process, process.log / "world.log")
        if log == "unreadable":
            process.log.chmod(0o000)
        return process.verdict(), process.was_dismissed

    verdicts, dismissed = asyncio.run(main())
    if log == "unreadable" and os.geteuid() == 0:  # root reads it
        assert verdicts == "fes-world: no room"
        return
    assert verdicts.startswith("fes-world ended with exit code 1 (its log cannot be read: ")
    assert dismissed
