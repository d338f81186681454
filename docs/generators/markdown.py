"""Markdown: headings and tables."""

import re
from collections.abc import Iterable, Sequence


def cell(text: str) -> str:
    """A text as a cell of a table: one line, with its bars escaped."""
    return " ".join(text.split()).replace("|", r"\|")


def code(text: str) -> str:
    """A text as code in a cell; an empty text stays empty."""
    return f"`{text}`" if text else ""


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The lines of a table, with an empty line after it."""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return [*lines, *("| " + " | ".join(map(cell, row)) + " |" for row in rows), ""]


def prose(docstring: str) -> str:
    """A docstring for Markdown: symbols that Markdown would read as emphasis are escaped outside of code."""
    parts = re.split(r"(`[^`]*`)", " ".join(docstring.split()))
    return "".join(part if part.startswith("`") else re.sub(r"([*_<])", r"\\\1", part) for part in parts)
