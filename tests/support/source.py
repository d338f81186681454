"""The project's own source: modules, their packages and their imports."""

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

from tests.support.paths import ROOT

PACKAGES = ("fes", "agents", "world", "field", "console")


def modules(*packages: str) -> dict[str, Path]:
    """Dotted name and file of every module; a package has its own name."""
    paths = [path for package in packages for path in sorted((ROOT / package).rglob("*.py"))]
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in paths]
    return dict(zip(names, paths, strict=True))


def imports(tree: ast.AST) -> Iterator[str]:
    """Every imported name: for `from a import b` both a and a.b, as b may be a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            assert node.module
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


@functools.cache
def imports_of(path: Path) -> frozenset[str]:
    """Every name that a module imports."""
    return frozenset(imports(ast.parse(path.read_text(encoding="utf-8"))))


def importers(of: str) -> set[str]:
    """The modules of the project that import `of` or something in it."""
    names = set()
    for name, path in modules(*PACKAGES).items():
        if any(imported == of or imported.startswith(f"{of}.") for imported in imports_of(path)):
            names.add(name)
    return names


def package(module: str) -> str:
    """The sub-package of a module, such as fes.arrays; a module directly in a top package counts as one."""
    return ".".join(module.split(".")[:2])


def arrows() -> dict[str, set[str]]:
    """Each sub-package -> the other sub-packages that it imports from."""
    known = {name: path for name, path in modules(*PACKAGES).items() if "." in name}
    packages = {package(name) for name in known}
    names: dict[str, set[str]] = {name: set() for name in packages}
    for name, path in known.items():
        for imported in imports_of(path):
            if package(imported) in packages:
                names[package(name)].add(package(imported))
    return {name: wanted - {name} for name, wanted in names.items()}
