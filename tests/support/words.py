"""The project's prose and identifiers, held against the rules of English.

`python -m tests.support.words [PATH]...` prints every offence as file:line: rule: text.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.support.paths import ROOT

PRODUCT = ("fes", "agents", "world", "console")
"""Packages whose identifiers are nouns of the domain."""

IDENTIFIERS = {
    "account": "metrics", "assembly": "marshalling", "at": "index, positions", "attendance": "participation",
    "breathing": "period_average", "chance": "draws", "complaints": "drops", "course": "run", "ears": "beacon_tap",
    "equipment": "faults", "found": "the noun", "hands": "control", "here": "the noun", "keeper": "checkpoints",
    "kept": "the noun", "kin": "processes", "legible": "decodable", "mouth": "outbox", "named": "selected",
    "names_us": "selected_by_peer", "nobody": "the noun", "one": "first, or the noun", "other": "second, or the noun",
    "preferred": "objective", "pull": "formation_vector", "roster": "registry", "said": "the noun",
    "stretch": "segment", "sums": "metrics", "tally": "link_errors", "there": "the noun", "told": "the noun",
    "turns": "ticks", "untold": "no_telemetry", "whole": "the noun", "wish": "objective", "wording": "marshalling",
}  # fmt: skip
"""Replaced names, and what took their place."""

PHRASES = {
    r"\bg(o|oes|oing|one) on (with|from)\b": "resume, continue",
    r"\bgone through again\b": "executed again",
    r"\bnobody\b": "no robot, no process: name it",
    r"\b(whoever|whatever|whom|whomever)\b": "name the subject",
    r"(?<!there )\b(is|are|was|were) no(?! (longer|more|less)\b)\b": "is not a",
    r"\bturn(s|ed|ing)? (it |them |robots? )?away\b": "reject",
    r"\b(left|leave|leaves|leaving) out\b": "exclude, omit",
    r"\bg(ive|ives|ave|iven|iving) (it |them )?up\b": "time out, stop trying",
    r"\bunder way\b": "running",
    r"\b(come|comes|came|coming) back\b": "restart, rejoin",
    r"\bonce a (kind|tick|second|minute)\b": "per",
    r"\b(line|message|byte|call|wake-up)s? a (kind|tick|second|peer|robot)\b": "per",
    r"\bthat there (is|are|was|were)\b": "the noun alone",
    r"\bsays so\b": "name the message",
}
"""Phrases of another language's word order, and better ones."""

OPENERS = re.compile(r"(What|Who|Whom|Whose|Whether|How|Where|When|Which|That)\b(?![^.]*\?)")
"""A docstring starts with a noun phrase or an imperative."""

HEADLESS = re.compile(r"(?:^|[.!;:] )(Who|What|Whoever|Whatever|Whom) [a-z]")
"""A sentence whose subject is a relative pronoun; questions aside."""

LONGEST_SENTENCE = 30
"""Words; the rule is 25, and a formula, a path or a list may stand for a few more."""


class Offence(NamedTuple):
    """A piece of prose, or an identifier, against a rule."""

    path: Path
    line: int
    rule: str
    text: str

    def __str__(self) -> str:
        return f"{self.path.relative_to(ROOT)}:{self.line}: {self.rule}: {self.text}"


def prose_of(path: Path) -> Iterator[tuple[int, str, bool]]:
    """The pieces of prose in a file: first line, text, and True if it is a docstring."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield from _paragraphs(text)
        return
    tree = ast.parse(text)
    docstrings: set[int] = set()
    for node in ast.walk(tree):
        for child in _statements(node):
            value = child.value if isinstance(child, ast.Expr) else None
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                docstrings.add(id(value))
                yield child.lineno, value.value, True
    parts = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in ast.walk(tree):
        message = _message(node) if id(node) not in docstrings | parts else ""
        if message.count(" ") >= 3 and "\n" not in message.strip():
            yield getattr(node, "lineno", 0), message, False
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and not token.string.startswith(("#!", "# type:", "# fmt:", "# noqa")):
            yield token.start[0], token.string.lstrip("# "), False


def _statements(node: ast.AST) -> list[ast.stmt]:
    return [*getattr(node, "body", [])] if isinstance(getattr(node, "body", None), list) else []


def _message(node: ast.AST) -> str:
    """The text of a string or an f-string, with x for what is put in."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "x" for part in node.values)
    return ""


def _paragraphs(text: str) -> Iterator[tuple[int, str, bool]]:
    """Paragraphs, list items and table cells of a page in Markdown; fenced blocks are code."""
    fenced, first, lines = False, 0, list[str]()
    for number, line in enumerate([*text.splitlines(), ""], 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            continue
        is_item = re.match(r"\s*([-*|#>]|\d+\.) ?", line)
        if lines and (fenced or not line.strip() or is_item):
            yield first, " ".join(lines), False
            lines = []
        if fenced or not line.strip():
            continue
        if line.lstrip().startswith("|"):
            yield from ((number, cell.strip(), False) for cell in line.split("|") if cell.strip(" -:"))
            continue
        if not lines:
            first = number
        lines.append(line.strip(" -*#>"))


def offences(path: Path) -> Iterator[Offence]:
    """Every offence of a file against the rules of prose."""
    for line, text, is_docstring in prose_of(path):
        plain = re.sub(r"`[^`]*`|\[([^]]*)\]\([^)]*\)|https?://\S+", lambda match: match[1] or "x", text)
        plain = " ".join(plain.split())
        if is_docstring and (opener := OPENERS.match(plain)):
            yield Offence(path, line, f"a docstring starts with {opener[1]!r}", plain[:80])
        for phrase, better in PHRASES.items():
            if match := re.search(phrase, plain, re.IGNORECASE):
                yield Offence(path, line, f"{match[0]!r}: {better}", plain[max(0, match.start() - 40) :][:100])
        if not is_docstring and (match := HEADLESS.search(plain)) and not plain.endswith("?"):
            yield Offence(path, line, f"a sentence starts with {match[1]!r}", plain[match.start() :][:80])
        for sentence in re.split(r"(?<=[.!?:;])\s+|\n\n", plain):
            if len(sentence.split()) > LONGEST_SENTENCE:
                yield Offence(path, line, f"a sentence of {len(sentence.split())} words", sentence[:80])


def identifiers(path: Path) -> Iterator[Offence]:
    """Every name of a module that is bound to something and that another name has replaced."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        bound: list[str] = []
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            bound = [node.name]
        elif isinstance(node, ast.arg):
            bound = [node.arg]
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            bound = [node.id if isinstance(node, ast.Name) else node.attr]
        for name in bound:
            if (plain := name.strip("_").lower()) in IDENTIFIERS:
                yield Offence(path, getattr(node, "lineno", 0), f"name {name!r}: {IDENTIFIERS[plain]}", "")


def project(*folders: str) -> list[Path]:
    """The files with prose: modules and pages."""
    files = [path for folder in folders for path in sorted((ROOT / folder).rglob("*")) if path.is_file()]
    return [path for path in files if path.suffix in (".py", ".md")]


def main() -> int:
    """Print every offence; returns 1 if there is one."""
    paths = [ROOT / word for word in sys.argv[1:]] or [ROOT / name for name in (*PRODUCT, "docs", "bench", "tests")]
    files = [file for path in paths for file in ([path] if path.is_file() else project(str(path.relative_to(ROOT))))]
    found = [offence for file in files for offence in offences(file)]
    found += [
        offence
        for file in files
        if file.suffix == ".py" and file.relative_to(ROOT).parts[0] in PRODUCT
        for offence in identifiers(file)
    ]
    print(*found, f"{len(found)} offences", sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
