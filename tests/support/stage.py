"""A world process that waits for two robots, with or without certificates, for tests that attack it."""

import asyncio
import json
import subprocess
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from console.backends.process_group import free_port
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command, start, until

RUN = "main"
SECONDS = 4.0
ROLES = ["world", "robot-0", "robot-1", "observer", "operator"]
HEAD = [str(CONFIGS / "pair.toml"), "--duration", str(SECONDS), "--rtf", "1", "--out", "out"]


class Stage:
    """A world that waits for two robots, and its log."""

    def __init__(self, where: Path, keyed: Path | None, words: Sequence[str]) -> None:
        self.where, self.keyed = where, keyed
        self.endpoint = f"{'tls' if keyed else 'tcp'}/127.0.0.1:{free_port()}"
        self.flags = ["--keys", str(keyed)] if keyed else []
        self.running: list[subprocess.Popen[str]] = []
        self.path = where / "said.log"
        with self.path.open("w") as stream:
            world = command("world.process", *HEAD, *words, "-l", self.endpoint, *self.flags)
            self.running.append(
                subprocess.Popen(world, cwd=where, stdin=subprocess.DEVNULL, stderr=stream, text=True)
            )
        until(lambda: "waiting for 2 robots" in self.log())

    def log(self) -> str:
        return self.path.read_text()

    def agent(self, robot: int) -> None:
        words = command("agents.process", "--id", str(robot), "-e", self.endpoint, *self.flags)
        self.running.append(start(words, self.where))

    async def over(self) -> bool:
        """True if the world and its agents ended with 0; waits for their end."""
        codes = [await asyncio.to_thread(process.wait, PATIENCE) for process in self.running]
        return codes == [0] * len(codes)

    def end(self) -> None:
        for process in self.running:
            if process.poll() is None:
                process.kill()
            process.communicate()

    @asynccontextmanager
    async def visitor(self, role: str) -> AsyncIterator[Bus]:
        own = team_keys.security(self.keyed, role) if self.keyed else {}
        async with bus.opened(Endpoints("client", (self.endpoint,), timeout=PATIENCE, security=own)) as opened:
            yield opened

    def digest(self) -> str:
        """Digest in the summary; empty without one."""
        summary = self.where / "out" / "summary.json"
        return str(json.loads(summary.read_text())["digest"]) if summary.exists() else ""


@asynccontextmanager
async def stage(where: Path, keyed: Path | None, words: Sequence[str] = ()) -> AsyncIterator[Stage]:
    """A stage; `words` are further flags of the world."""
    staged = Stage(where, keyed, words)
    try:
        async with asyncio.timeout(100.0):
            yield staged
    finally:
        staged.end()
