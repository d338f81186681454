"""The project's prose and identifiers, held against the rules of English.

`python -m tests.support.words [PATH]...` prints every offence as file:line: rule: text.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.support.paths import ROOT
from tests.support.prose import Prose, prose_of

PRODUCT = ("fes", "agents", "world", "field", "console")
"""Packages whose identifiers are nouns of the domain."""

IDENTIFIERS = {
    "account": "metrics", "assembly": "marshalling", "at": "index, positions", "attendance": "participation",
    "breathing": "period_average", "chance": "draws", "complaints": "drops", "course": "run", "ears": "beacon_tap",
    "equipment": "faults", "found": "the noun", "hands": "control", "here": "the noun", "keeper": "checkpoints",
    "kept": "the noun", "kin": "processes", "legible": "decodable", "mouth": "outbox", "named": "selected",
    "names_us": "selected_by_peer", "nobody": "the noun", "one": "first, or the noun", "other": "second, or the noun",
    "preferred": "objective", "roster": "registry", "said": "the noun",
    "stretch": "segment", "sums": "metrics", "tally": "link_errors", "there": "the noun", "told": "the noun",
    "turns": "ticks", "untold": "no_telemetry", "whole": "the noun", "wish": "objective", "wording": "marshalling",
}  # fmt: skip
"""Replaced names, and their replacements."""

PARTNERS = {"whole": "part", "other": "own", "named": "unnamed"}
"""Replaced names that are the right word beside another: whole and part, own and other. `other` may follow `self`."""

UNIT_OF_RATE = "(kind|tick|second|minute|peer|robot|link|agent|process|run)"

PHRASES = {
    r"\bg(o|oes|oing|one) on (with|from)\b": "resume, continue",
    r"\bthat (go|goes|went) on\b(?! (beyond|the|to)\b)": "running",
    r"\bgone through again\b": "executed again",
    r"\bnobody\b": "no robot, no process: name it",
    r"\b(whoever|whatever|whom|whomever)\b": "name the subject",
    r"(?<!there )\b(is|are|was|were) no\b(?! (longer|more|less|later|earlier)\b)": "is not a",
    r"\bcan (\w+ )?nothing\b": "cannot",
    r"\bturn(s|ed|ing)? (it |them |robots? )?away\b": "reject",
    r"\b(left|leave|leaves|leaving) out\b": "exclude, omit",
    r"\bg(ive|ives|ave|iven|iving) (it |them )?up\b": "time out, stop trying",
    r"\bunder way\b": "running",
    r"\bfor good\b": "permanently",
    r"\b(come|comes|came|coming) back\b": "restart, rejoin",
    rf"\bonce an? {UNIT_OF_RATE}\b": "per",
    rf"(?<!the )(?<!every )\b(line|message|byte|call|wake-up|KiB|MiB|us|ms)s? an? {UNIT_OF_RATE}\b": "per",
    r"\bthat there (is|are|was|were)\b(?! (a|an|any|no|nothing|one|two|only|more)\b)": "the noun alone",
    r"\bsays so\b": "name the message",
}
"""Phrases of another language's word order, and better ones."""

OPENERS = re.compile(r"(What|Who|Whom|Whose|Whether|How|Where|When|Which|That|Not|Nothing|None of)\b(?![^.]*\?)")
"""A docstring starts with a noun phrase or an imperative."""

HEADLESS = re.compile(r"(?:^|(?<=[.!;:] ))(Who|What|Whoever|Whatever|Whom|Whose) [a-z](?![^.!;:]*\?)")
"""A sentence whose subject is a relative pronoun; questions aside."""

SENTENCE_NAME = re.compile(r"test_(who|what|whom|whose|whoever|whatever)_")
"""A test's name is a sentence whose subject is a noun."""

LONGEST_SENTENCE = 25
"""Words. Numbers, symbols and formulas are not counted."""

WORD = re.compile(r"[(\"']*([A-Za-z]{2,}|[aAI])([-'/][A-Za-z]+)*[)\"',.:;!?]*")
SENTENCE_ENDS = re.compile(r"(?<=[.!?:;])[)\"']*\s+")
CODE = re.compile(r"`[^`]*`|\[([^]]*)\]\([^)]*\)|https?://\S+")


class Offence(NamedTuple):
    """A piece of prose, or an identifier, that breaks a rule."""

    path: Path
    line: int
    rule: str
    text: str

    def __str__(self) -> str:
        return f"{self.path.relative_to(ROOT)}:{self.line}: {self.rule}: {self.text}"


def offences(path: Path) -> Iterator[Offence]:
    """Every offence of a file against the rules of prose."""
    for piece in prose_of(path):
        yield from (Offence(path, piece.line, rule, text) for rule, text in offences_of(piece))
    if path.suffix == ".py" and path.name.startswith("test_"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name.startswith("test_"):
                sentence = Prose(node.lineno, node.name.removeprefix("test_").replace("_", " "))
                if match := SENTENCE_NAME.match(node.name):
                    yield Offence(path, node.lineno, f"a test's name starts with {match[1]!r}", node.name)
                yield from (Offence(path, node.lineno, rule, text) for rule, text in offences_of(sentence))


def offences_of(piece: Prose) -> Iterator[tuple[str, str]]:
    """The rules that a piece of prose breaks, each with an excerpt."""
    plain = " ".join(CODE.sub(lambda match: match[1] or "x", piece.text).replace("**", "").split())
    if opener := OPENERS.match(plain) if piece.opens else None:
        yield f"a docstring starts with {opener[1]!r}", plain[:80]
    elif match := HEADLESS.search(plain):
        yield f"a sentence starts with {match[1]!r}", plain[match.start() :][:80]
    for phrase, better in PHRASES.items():
        if match := re.search(phrase, plain, re.IGNORECASE):
            yield f"{match[0]!r}: {better}", plain[max(0, match.start() - 40) :][:100]
    for sentence in SENTENCE_ENDS.split(plain):
        words = sum(1 for word in sentence.split() if WORD.fullmatch(word))
        if words > LONGEST_SENTENCE:
            yield f"a sentence of {words} words", sentence[:80]


def identifiers(path: Path) -> Iterator[Offence]:
    """Every name that a module binds and that another name has replaced."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = _bound(node)
        for name in names:
            plain = name.strip("_").lower()
            is_paired = PARTNERS.get(plain) in names or (plain == "other" and "self" in names)
            if plain in IDENTIFIERS and not is_paired:
                line = getattr(getattr(node, "target", node), "lineno", 0)
                yield Offence(path, line, f"name {name!r}: {IDENTIFIERS[plain]}", "")


def _bound(node: ast.AST) -> list[str]:
    """Names that a statement binds together: those of a function and its arguments, or of an assignment."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return [node.name, *_arguments(node.args)]
    if isinstance(node, ast.Lambda):
        return _arguments(node.args)
    if isinstance(node, ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation).startswith("Annotated"):
        return []  # a key of a scenario
    targets = [*getattr(node, "targets", []), getattr(node, "target", None), getattr(node, "optional_vars", None)]
    stored = [part for target in targets if isinstance(target, ast.AST) for part in ast.walk(target)]
    return [
        part.id if isinstance(part, ast.Name) else part.attr
        for part in stored
        if isinstance(part, ast.Name | ast.Attribute) and isinstance(part.ctx, ast.Store)
    ]


def _arguments(arguments: ast.arguments) -> list[str]:
    return [part.arg for part in ast.walk(arguments) if isinstance(part, ast.arg)]


def files_of(*names: str) -> list[Path]:
    """Modules and pages in the given folders and files, named relative to the root."""
    roots = [ROOT / name for name in names]
    paths = [file for root in roots for file in ([root] if root.is_file() else root.rglob("*"))]
    return [path for path in sorted(paths) if path.suffix in (".py", ".md") and path.is_file()]


EXAMPLES = (ROOT / "tests/support/words.py", ROOT / "tests/architecture/test_words.py")
"""Files that quote what the rules forbid."""

PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
CHECKED = [path for path in files_of(*PRODUCT, "docs", "bench", "tests", *PAGES) if path not in EXAMPLES]
"""Every module and page whose prose keeps the rules."""


def is_product(path: Path) -> bool:
    """True for a module whose identifiers are nouns of the domain."""
    return path.suffix == ".py" and path.relative_to(ROOT).parts[0] in PRODUCT


def main() -> int:
    """Print every offence; returns 1 if there is one."""
    files = files_of(*sys.argv[1:]) if sys.argv[1:] else CHECKED
    listed = [offence for file in files for offence in offences(file)]
    listed += [offence for file in files if is_product(file) for offence in identifiers(file)]
    print(*listed, f"{len(listed)} offences", sep="\n")
    return 1 if listed else 0


if __name__ == "__main__":
    sys.exit(main())
