"""Folders of the clone that is under test."""

from pathlib import Path

ROOT = Path(__file__).absolute().parents[2]
CONFIGS = ROOT / "configs"
DOCS = ROOT / "docs"
FORMATS = ROOT / "tests" / "formats"
PAIR = str(CONFIGS / "pair.toml")
"""Scenario of two robots, as a word of a command."""
