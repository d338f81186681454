"""The program of agent.c: an agent's tick under the sanitizers for addresses and undefined behavior."""

import subprocess
from pathlib import Path

import build_core
from tests.support.paths import ROOT

SANITIZED = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DFES_ONE_VERSION")


def build(folder: Path) -> Path:
    """Compile the program into a folder. Raises build_core.NotBuilt, or CalledProcessError without the sanitizers."""
    program = folder / "agent"
    usual = [flag for flag in build_core.FLAGS if flag.startswith(("-std", "-W", "-ffp", "-fno"))]
    sources = [ROOT / "tests/fuzz/agent.c", *sorted((ROOT / "agents/core").glob("*.c"))]
    command = [*build_core.compiler(), *usual, *SANITIZED, f"-I{ROOT}", "-o", str(program), *map(str, sources)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return program


def run(program: Path, seconds: int, seed: int) -> str:
    """The line that a run prints; raises CalledProcessError with the report of a sanitizer."""
    done = subprocess.run([program, str(seconds), str(seed)], check=True, capture_output=True, text=True)
    return done.stdout.strip()
