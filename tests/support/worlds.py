"""Runs of `fes run` whose world dies."""

import asyncio
import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from console.backends.process_group import free_port
from fes.protocol import keys
from tests.support import session
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command, start, until
from world.execution import checkpoint, journal
from world.execution.checkpoint import FOLDER
from world.execution.run import TICK

DURATION = 20.0
"""Simulated length of a run [s]."""


class Run:
    """fes-world and its agents, started by hand."""

    def __init__(self, where: Path, scenario: str, *words: str) -> None:
        self.where, self.words = where, words
        self.out = where / "out"
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.scenario = scenario
        self.agents: dict[int, subprocess.Popen[str]] = {}
        self.world = self.start(str(CONFIGS / scenario), "--out", str(self.out), *words)

    def start(self, *words: str, every: str = "0.5", rtf: str = "2") -> "subprocess.Popen[str]":
        """Start a world that executes the run from now on, with a checkpoint `every` [s]."""
        flags = ["-l", self.endpoint, "--checkpoint", every, "--rtf", rtf]
        self.world = start(command("world.process", *words, *flags), self.where)
        return self.world

    def join(self, robot: int) -> None:
        """Start an agent."""
        words = ["--id", str(robot), "-e", self.endpoint]
        self.agents[robot] = start(command("agents.process", *words), self.where)

    def next_checkpoint(self) -> None:
        """Wait until the present checkpoint has a successor, which shows that the run progresses."""
        state = self.out / FOLDER / "state"
        until(state.exists)
        seen = state.stat().st_ino
        until(lambda: state.stat().st_ino != seen)

    def reached(self) -> int:
        """Last tick in its notes; -1 for none."""
        with suppress(OSError):  # a journal may be replaced just now
            return max((tick for kind, tick, *_ in self.notes() if kind == TICK), default=-1)
        return -1

    def notes(self) -> list[list[Any]]:
        """Notes that its checkpoint does not hold yet, and perhaps more."""
        return [note for path in checkpoint.journals(self.out, 0) for note in journal.notes(path)]

    def end(self, how: signal.Signals) -> None:
        """End the world, by the present checkpoint's successor at the earliest."""
        self.next_checkpoint()
        self.world.send_signal(how)
        self.world.communicate(timeout=PATIENCE)

    def come_to_rest(self, robot: int) -> None:
        """Suspend an agent until the world resends its tick: all others have answered by then."""

        async def main() -> None:
            async with session.client(self.endpoint) as observer, asyncio.timeout(PATIENCE):
                mailbox, seen = observer.mailbox(keys.observation(keys.DEFAULT_RUN, robot)), set[bytes | None]()
                while (sample := mailbox.take()) is None or not seen:
                    seen.update(sample[1:] if sample else ())
                    await asyncio.sleep(0.001)
                self.agents[robot].send_signal(signal.SIGSTOP)
                while (sample := mailbox.take()) is None or sample[1] not in seen:
                    seen.update(sample[1:] if sample else ())
                    await asyncio.sleep(0.001)

        asyncio.run(main())

    def finish(self) -> dict[str, Any]:
        """The summary, when all have ended well."""
        for process in (self.world, *self.agents.values()):
            _, err = process.communicate(timeout=4 * PATIENCE)
            assert process.returncode == 0, err
        assert not (self.out / FOLDER).exists()
        summary: dict[str, Any] = json.loads((self.out / "summary.json").read_text())
        return summary


@contextmanager
def under_way(where: Path, scenario: str, duration: float = DURATION) -> Iterator[Run]:
    """A run of `duration` [s], whose processes are killed at the end."""
    going = Run(where, scenario, "--duration", str(duration))
    try:
        yield going
    finally:
        for process in (going.world, *going.agents.values()):
            if process.poll() is None:
                process.kill()
            process.communicate()
