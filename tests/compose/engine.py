"""The engine: Docker's command line, and the engine's network namespace."""

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
"""Time limit of a condition [s]."""

LONGEST = 300.0
"""Time limit of a command [s]."""


class Broken(Exception):
    """A claim that does not hold."""


def claim(holds: bool, claimed: str) -> None:
    """Print a claim that holds; raises Broken if it does not."""
    if not holds:
        raise Broken(claimed)
    print(f"compose:   {claimed}", flush=True)


def call(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A command's exit code and output, with its stderr."""
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


def wait(claimed: str, holds: Callable[[], bool]) -> None:
    """Wait until a condition holds; raises Broken after DEADLINE."""
    end = time.monotonic() + DEADLINE
    while not holds():
        if time.monotonic() > end:
            raise Broken(f"{claimed}: not within {DEADLINE:g} s")
        time.sleep(0.02)
    claim(True, claimed)


class BackgroundCommand:
    """A command that runs beside the claims while a thread collects its output."""

    def __init__(self, *words: str, **environment: str) -> None:
        self._words = words
        self._gatherer = ThreadPoolExecutor(1)
        self._done = self._gatherer.submit(lambda: call(*words, **environment))

    def end(self) -> tuple[int, str]:
        """Exit code and output after its end; raises Broken after LONGEST."""
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
        """The words of a Compose command."""
        return ("docker", "compose", *words)

    def compose(self, *words: str) -> str:
        """The output of a Compose command; raises Broken if it fails."""
        return output(*self.words(*words), **self._settings)

    def attempt(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Exit code and output of a Compose command that may fail."""
        return call(*self.words(*words), **self._settings)

    def start(self, *words: str) -> BackgroundCommand:
        """Start a Compose command that runs beside the claims."""
        return BackgroundCommand(*self.words(*words), **self._settings)

    def log(self, service: str) -> str:
        """The log of a service."""
        return self.compose("logs", "--no-color", "--no-log-prefix", service)

    def containers(self) -> list[dict[str, Any]]:
        """Docker's description of each container of the team."""
        containers: list[dict[str, Any]] = json.loads(output("docker", "inspect", *self.compose("ps", "-aq").split()))
        return containers

    def summary(self, run: str) -> dict[str, Any]:
        """The summary in the run directory on the volume."""
        with tempfile.TemporaryDirectory() as folder:
            self.compose("cp", f"{self.world}:/srv/runs/{run}/summary.json", folder)
            summary: dict[str, Any] = json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8"))
        return summary

    def end(self) -> None:
        """Remove the team; raises Broken if a container, volume or network is left."""
        self.compose("--profile", "*", "down", "-v")
        for listing in ("container ls -a", "volume ls"):
            claim(output("docker", *listing.split(), "-q").split() == [], f"after down: `docker {listing}` is empty")
        networks = set(output("docker", "network", "ls", "--format", "{{.Name}}").split())
        claim(networks == {"bridge", "host", "none"}, "after down: no network is left")


class Network:
    """The network namespace of the engine, by its name."""

    def __init__(self, namespace: str) -> None:
        self._enter = ("nsenter", f"--net=/run/netns/{namespace}")

    def call(self, *words: str) -> str:
        """The output of a command in the namespace; raises Broken if it fails."""
        return output(*self._enter, *words)
