"""Prose of the project, piece by piece: docstrings, messages and comments of modules, and pages in Markdown."""

import ast
import inspect
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

NEW_PIECE = re.compile(r"[-*>\s|├└│]|\d+\. |\S+ {2,}\S")
"""A line of a docstring that continues no sentence: an item, a line of a map or of a table, an indented line."""


class Prose(NamedTuple):
    """A piece of prose: a paragraph, an item, a message or a comment."""

    line: int
    text: str
    opens: bool = False
    """True if a docstring starts with it."""


def prose_of(path: Path) -> Iterator[Prose]:
    """The pieces of prose in a file."""
    text = path.read_text(encoding="utf-8")
    yield from _paragraphs(text) if path.suffix == ".md" else _prose_of_module(text)


def _prose_of_module(text: str) -> Iterator[Prose]:
    nodes = list(ast.walk(ast.parse(text)))
    taken = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in nodes:
        body = getattr(node, "body", None)
        for child in body if isinstance(body, list) else []:
            if isinstance(child, ast.Expr) and (docstring := _message(child.value)):
                taken.add(id(child.value))
                yield from _docstring(child.lineno, docstring)
    for node in nodes:
        message = _message(node) if id(node) not in taken else ""
        if message.count(" ") >= 3 and "\n" not in message.strip():
            yield Prose(getattr(node, "lineno", 0), message)
    yield from _comments(text)


def _message(node: ast.AST) -> str:
    """The text of a string or an f-string, with x for each value."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "x" for part in node.values)
    return ""


def _docstring(first: int, text: str) -> Iterator[Prose]:
    """The paragraphs, items and map lines of a docstring, without its examples, tables and drawings."""
    piece, example = Prose(first, "", opens=True), False
    for number, line in enumerate([*inspect.cleandoc(text).splitlines(), ""], first):
        is_code = line.lstrip().startswith((">>>", "|", "├", "└", "│"))
        if piece.text and (is_code or not line.strip() or NEW_PIECE.match(line)):
            yield piece
            piece = Prose(number, "")
        example = bool(line.strip()) and (example or line.lstrip().startswith(">>>"))
        if not is_code and not example and line.strip():
            start = piece.line if piece.text else number
            piece = Prose(start, f"{piece.text} {line.strip(' -*')}", piece.opens)
    if piece.text:
        yield piece


def _comments(text: str) -> Iterator[Prose]:
    """Comments, those of adjacent lines as one."""
    piece, last = Prose(0, ""), (0, 0)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type != tokenize.COMMENT or token.string.startswith(("#!", "# type:", "# fmt:", "# noqa")):
            continue
        if token.start == (last[0] + 1, last[1]):
            piece = piece._replace(text=f"{piece.text} {token.string.lstrip('# ')}")
        else:
            yield piece
            piece = Prose(token.start[0], token.string.lstrip("# "))
        last = token.start
    yield piece


def _paragraphs(text: str) -> Iterator[Prose]:
    """Paragraphs, list items and table cells of a page in Markdown; fenced blocks and headings are not."""
    fenced, first, lines = False, 0, list[str]()
    for number, line in enumerate([*text.splitlines(), ""], 1):
        is_fence = line.lstrip().startswith("```")
        if lines and (is_fence or not line.strip() or re.match(r"\s*([-*|#>]|\d+\.) ?", line)):
            yield Prose(first, " ".join(lines))
            lines = []
        fenced ^= is_fence
        is_code = is_fence or fenced or (line.startswith("    ") and not lines)
        if is_code or not line.strip() or line.startswith("#"):
            continue
        if line.lstrip().startswith("|"):
            yield from (Prose(number, cell.strip()) for cell in line.split("|") if cell.strip(" -:"))
            continue
        first = first if lines else number
        lines.append(line.strip(" -*>"))
