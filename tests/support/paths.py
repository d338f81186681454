"""Folders of the clone that is under test."""

from pathlib import Path

ROOT = Path(__file__).absolute().parents[2]
CONFIGS = ROOT / "configs"
DOCS = ROOT / "docs"
FORMATS = ROOT / "tests" / "formats"
