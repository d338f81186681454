"""The project's own source: modules and what they import."""

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.support.paths import ROOT

ROOMS = ("fes", "agents", "world", "console")


def modules(*rooms: str) -> dict[str, Path]:
    """Dotted name and file of every module, a package by its own name."""
    paths = [path for room in rooms for path in sorted((ROOT / room).rglob("*.py"))]
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in paths]
    return dict(zip(names, paths, strict=True))


def imports(tree: ast.AST) -> Iterator[str]:
    """Everything that is imported: for `from a import b` both a and a.b, as b may be a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            assert node.module
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


def importers(of: str) -> set[str]:
    """The modules of the project that import `of` or something in it."""
    found = set()
    for name, path in modules(*ROOMS).items():
        wanted = imports(ast.parse(path.read_text(encoding="utf-8")))
        if any(imported == of or imported.startswith(f"{of}.") for imported in wanted):
            found.add(name)
    return found
