"""`--use`: which modules it allows, and what a module that is used again becomes."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fes.errors import FesError
from fes.extension import registry
from fes.extension.kinds import Kind


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A folder whose modules are forgotten afterwards."""
    before, path = set(sys.modules), list(sys.path)
    yield tmp_path
    sys.path[:] = path
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]
            registry.withdraw(name)


def written(file: Path, text: str = "class Law: pass\n") -> str:
    """The path of a file that now has this text."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return str(file)


def test_no_module_of_the_project_becomes_that_of_an_extension() -> None:
    name = registry.use("world.metrics.team.travel")
    assert not registry.is_usable("world.metrics.team.travel")
    assert not registry.is_usable("world.execution.checkpoint")
    assert name in registry.used()
    registry.withdraw(name)
    assert name not in registry.used()


@pytest.mark.parametrize(
    ("file", "text", "error"),
    [
        ("json.py", "", "ImportError: another module is named 'json': rename the file"),
        ("law_that_fails.py", "1 / 0", "ZeroDivisionError: division by zero"),
    ],
)
def test_a_module_that_is_rejected_leaves_nothing_behind(folder: Path, file: str, text: str, error: str) -> None:
    path, used = list(sys.path), registry.used()
    argument = written(folder / file, text)
    with pytest.raises(FesError) as raised:
        registry.use(argument)
    assert str(raised.value) == f"--use {argument}: {error}"
    assert not registry.is_usable(Path(file).stem)
    assert (sys.path, registry.used()) == (path, used)


def test_withdrawing_a_package_leaves_its_module_allowed(folder: Path) -> None:
    written(folder / "toy_package" / "__init__.py", "")
    written(folder / "toy_package" / "law.py")
    sys.path.append(str(folder))
    for name in ("toy_package", "toy_package.law"):
        registry.use(name)
    registry.withdraw("toy_package")
    assert registry.used()[-1] == "toy_package.law"
    assert "toy_package" not in registry.used()


def test_of_a_package_only_the_modules_that_were_told_are_usable(folder: Path) -> None:
    written(folder / "narrow_package" / "__init__.py", "from narrow_package import imported")
    for name in ("law", "imported", "absent"):
        written(folder / "narrow_package" / f"{name}.py")
    sys.path.append(str(folder))
    registry.use("narrow_package.law")
    assert registry.is_usable("narrow_package.law")
    for other in ("narrow_package", "narrow_package.imported", "narrow_package.absent"):
        assert not registry.is_usable(other)


def test_the_module_of_a_class_that_its_package_offers_is_usable_and_that_of_another_package_is_not(
    folder: Path,
) -> None:
    written(
        folder / "offering" / "__init__.py", "from offering.law import Law\nfrom decimal import Context as Borrowed\n"
    )
    written(folder / "offering" / "law.py")
    sys.path.append(str(folder))
    registry.use("offering")
    kind = Kind("toy", "fes.tests_without_toys", {})
    for name in ("Law", "Borrowed"):
        registry.load(kind, f"offering:{name}")
    assert registry.is_usable("offering.law")
    assert not registry.is_usable("decimal")
