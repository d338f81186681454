"""The programs of agent.c and world.c: readers of messages under sanitizers for addresses and undefined behavior."""

import subprocess
from pathlib import Path

import build_core
from tests.support.paths import ROOT

SANITIZED = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DFES_ONE_VERSION")

PROGRAMS = {"agent": "agents/core/*.c", "world": "world/simulation/core/messages.c"}
"""Program -> the sources of the core that it tests."""


def build(name: str, folder: Path) -> Path:
    """Compile a program into a folder. Raises build_core.NotBuilt, or CalledProcessError without the sanitizers."""
    program = folder / name
    usual = [flag for flag in build_core.FLAGS if flag.startswith(("-std", "-W", "-ffp", "-fno"))]
    sources = [ROOT / f"tests/fuzz/{name}.c", *sorted(ROOT.glob(PROGRAMS[name]))]
    command = [*build_core.compiler(), *usual, *SANITIZED, f"-I{ROOT}", "-o", str(program), *map(str, sources)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return program


def run(program: Path, seconds: int, seed: int) -> str:
    """The line that a run prints; raises CalledProcessError with the report of a sanitizer."""
    done = subprocess.run([program, str(seconds), str(seed)], check=True, capture_output=True, text=True)
    return done.stdout.strip()
