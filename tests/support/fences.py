"""Fenced blocks of the pages: their language, their text, and the comment above that marks how they are tested."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.support.paths import DOCS, ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]

RUN = "run"
"""Mark of blocks that `tests/system/test_documents.py` runs, page by page and language by language, in order."""

BY_SCRIPTS = ("run command", "test command")
"""Marks of blocks that `.ci/run` and `tests/other_python/run` take from the README and run."""

NOT_RUN = re.compile(r"not run: \S.*")
"""Mark of a block that is not run, with the reason."""

FILE = re.compile(r"file: ([\w.-]+)")
"""Mark of a block that a reader writes to a file, with its name."""

_MARK = re.compile(r"<!-- (.*) -->")


class Block(NamedTuple):
    """A fenced block of a page."""

    page: Path
    line: int
    language: str
    mark: str
    """Text of the comment in the line above; empty without one."""
    text: str


def blocks(page: Path) -> Iterator[Block]:
    """The fenced blocks of a page, in order."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = None
    for index, line in enumerate(lines):
        if not line.lstrip().startswith("```"):
            continue
        if start is None:
            start = index
            continue
        mark = _MARK.fullmatch(lines[start - 1].strip()) if start else None
        text = "\n".join(lines[start + 1 : index]) + "\n"
        yield Block(page, start + 1, lines[start].strip("` "), mark[1] if mark else "", text)
        start = None


def python(page: Path) -> list[Block]:
    """The blocks of a page that Python can run."""
    return [block for block in blocks(page) if block.language == "python"]


def shell(page: Path) -> list[Block]:
    """The blocks of a page that a shell can run."""
    return [block for block in blocks(page) if block.language == "sh"]
