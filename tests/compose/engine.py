"""The engine, as used by the claims: Docker's command line, and the engine's network namespace."""

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]

DEADLINE = 90.0
"""Longest wait for an expected event [s]."""

LONGEST = 300.0
"""Timeout of a command [s]."""


class Broken(Exception):
    """A claim that does not hold."""


def claim(holds: bool, what: str) -> None:
    """Print a claim that holds; raises Broken if it does not."""
    if not holds:
        raise Broken(what)
    print(f"compose:   {what}", flush=True)


def call(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A command's exit code and output, of stderr too."""
    return subprocess.run(
        words,
        cwd=ROOT,
        env={**os.environ, **environment},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LONGEST,
        check=False,
    )


def output(*words: str, **environment: str) -> str:
    """A command's output; raises Broken if it fails."""
    done = call(*words, **environment)
    if done.returncode != 0:
        raise Broken(f"{' '.join(words)}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout


def wait(what: str, holds: Callable[[], bool]) -> None:
    """Wait until something holds; raises Broken if it does not in time."""
    end = time.monotonic() + DEADLINE
    while not holds():
        if time.monotonic() > end:
            raise Broken(f"{what}: not within {DEADLINE:g} s")
        time.sleep(0.02)
    claim(True, what)


class Beside:
    """A background command whose output a thread collects."""

    def __init__(self, *words: str, **environment: str) -> None:
        self._words = words
        self._gatherer = ThreadPoolExecutor(1)
        self._done = self._gatherer.submit(lambda: call(*words, **environment))

    def end(self) -> tuple[int, str]:
        """Exit code and output after its end; raises Broken if it does not end."""
        try:
            done = self._done.result(LONGEST)
        except (TimeoutError, subprocess.TimeoutExpired):
            raise Broken(f"{' '.join(self._words)} does not end") from None
        return done.returncode, done.stdout


class Team:
    """A profile of compose.yaml with its settings."""

    def __init__(self, profile: str, world: str, **settings: str) -> None:
        self.world = world
        self._settings = {"COMPOSE_PROFILES": profile, **settings}

    def words(self, *words: str) -> tuple[str, ...]:
        """A Compose command."""
        return ("docker", "compose", *words)

    def compose(self, *words: str) -> str:
        """The output of a Compose command; raises Broken if it fails."""
        return output(*self.words(*words), **self._settings)

    def attempt(self, *words: str) -> subprocess.CompletedProcess[str]:
        """A Compose command that may fail."""
        return call(*self.words(*words), **self._settings)

    def beside(self, *words: str) -> Beside:
        """A Compose command in the background."""
        return Beside(*self.words(*words), **self._settings)

    def log(self, service: str) -> str:
        """The log of a service."""
        return self.compose("logs", "--no-color", "--no-log-prefix", service)

    def containers(self) -> list[dict[str, Any]]:
        """The engine's description of each container of the team."""
        found: list[dict[str, Any]] = json.loads(output("docker", "inspect", *self.compose("ps", "-aq").split()))
        return found

    def summary(self, run: str) -> dict[str, Any]:
        """The summary in the run directory on the volume."""
        with tempfile.TemporaryDirectory() as here:
            self.compose("cp", f"{self.world}:/srv/runs/{run}/summary.json", here)
            found: dict[str, Any] = json.loads((Path(here) / "summary.json").read_text(encoding="utf-8"))
        return found

    def end(self) -> None:
        """Remove the team with all of its volumes and networks."""
        self.compose("--profile", "*", "down", "-v")
        for what in ("container ls -a", "volume ls"):
            claim(output("docker", *what.split(), "-q").split() == [], f"after down: `docker {what}` is empty")
        networks = set(output("docker", "network", "ls", "--format", "{{.Name}}").split())
        claim(networks == {"bridge", "host", "none"}, "after down: no network is left")


class Network:
    """The network namespace of the engine, by its name."""

    def __init__(self, namespace: str) -> None:
        self._enter = ("nsenter", f"--net=/run/netns/{namespace}")

    def call(self, *words: str) -> str:
        """The output of a command in the namespace; raises Broken if it fails."""
        return output(*self._enter, *words)
