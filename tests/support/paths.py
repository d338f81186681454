"""Folders of the clone that is under test."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).absolute().parents[2]
CONFIGS = ROOT / "configs"
DOCS = ROOT / "docs"
FORMATS = ROOT / "tests" / "formats"
PAIR = str(CONFIGS / "pair.toml")
"""Scenario of two robots, as a word of a command."""


def tracked() -> list[Path]:
    """Every file of the repository."""
    done = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=ROOT, capture_output=True, check=True, timeout=60
    )
    paths = [ROOT / name for name in done.stdout.decode().split("\0") if name]
    return [path for path in paths if path.is_file()]
