"""A running `fes run`, and the deaths of its agents."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, alive, children, fes, start, until

BEGUN = "all robots are here"


class Run:
    """A running `fes run`."""

    def __init__(self, where: Path, scenario: str, *words: str) -> None:
        self.out = where / "out"
        self.seen: set[int] = set()
        call = fes("run", str(CONFIGS / scenario), "--headless", "--out", "out", *words)
        self.running = start(call, where)

    def log(self, name: str = "world") -> str:
        path = self.out / f"{name}.log"
        return path.read_text() if path.exists() else ""

    def pid(self, robots: str) -> int:
        """Process id of the current agent of `robots`."""

        def found() -> list[int]:
            pids = children(self.running.pid)
            self.seen |= set(pids)
            return [pid for pid, line in pids.items() if f" -m agents --id {robots} " in line and alive(pid)]

        return int(until(found)[0])

    def kill(self, *robots: str, how: signal.Signals = signal.SIGKILL) -> None:
        pids = [self.pid(robot) for robot in robots]
        for pid in pids:
            os.kill(pid, how)
        until(lambda: not any(alive(pid) for pid in pids))

    def end(self) -> tuple[int, str, list[str]]:
        """Exit code, standard output, and messages after the first line; no process may remain."""
        self.seen |= set(children(self.running.pid))
        out, err = self.running.communicate(timeout=2 * PATIENCE)
        until(lambda: not any(alive(pid) for pid in self.seen))
        first, *output = err.splitlines()
        assert first.startswith("starting a world and ")
        return self.running.returncode, out, output


@contextmanager
def under_way(where: Path, scenario: str, *words: str, begun: bool = True) -> Iterator[Run]:
    run = Run(where, scenario, *words)
    try:
        if begun:
            until(lambda: BEGUN in run.log())
        yield run
    finally:
        if run.running.poll() is None:
            run.running.kill()
        run.running.communicate()


def warned(robots: str, how: str) -> str:
    ids = robots.split()[-1]
    whom = "them" if "-" in ids else "it"
    line = f"fes-agent --id {ids} {how} (its log: out/agent-{ids}.log)"
    return f"fes: warning: {robots}: {line}; the run continues without {whom}"
