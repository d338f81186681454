"""`--use`: which modules it allows, and what a module that is used again becomes."""

import os
import sys
from pathlib import Path
from types import ModuleType

import pytest

from fes.errors import FesError
from fes.extension import registry
from fes.extension.kinds import Kind

TOY = Kind("toy", "fes.tests_without_toys", {})


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
    for name in ("Law", "Borrowed"):
        registry.load(TOY, f"offering:{name}")
    assert registry.is_usable("offering.law")
    assert not registry.is_usable("decimal")


def test_a_module_that_is_used_again_is_imported_again_only_if_its_file_has_changed(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    argument = written(folder / "edited_toy.py", "class Law: number = 1\n")
    os.utime(argument, (1e9, 1e9))
    first = [registry.load(TOY, f"{registry.use(argument)}:Law") for _ in range(2)]
    assert first[0] is first[1]
    written(folder / "edited_toy.py", "class Law: number = 2\n")
    os.utime(argument, (1e9, 1e9))  # of the same second and size: the cached bytecode seems valid
    assert registry.load(TOY, "edited_toy:Law").number == 1
    registry.use(argument)
    assert registry.load(TOY, "edited_toy:Law").number == 2


def test_a_package_is_imported_again_with_all_its_modules(folder: Path) -> None:
    written(folder / "edited_package" / "__init__.py", "")
    written(folder / "edited_package" / "law.py", "from edited_package.part import Law as Law\n")
    written(folder / "edited_package" / "other.py", "from edited_package.part import Law as Law\n")
    sys.path.append(str(folder))
    for number in (1, 2):
        written(folder / "edited_package" / "part.py", f"class Law: number = {number}\n")
        registry.use("edited_package.law")
        if number == 1:
            registry.use("edited_package.other")
        for module in ("law", "other"):
            assert registry.load(TOY, f"edited_package.{module}:Law").number == number


def test_an_edit_that_fails_leaves_the_former_module_until_it_is_mended(folder: Path) -> None:
    argument = written(folder / "broken_toy.py", "class Law: number = 1\n")
    registry.use(argument)
    former = sys.modules["broken_toy"]
    written(folder / "broken_toy.py", "class Law: number =\n")
    for _ in range(2):
        with pytest.raises(FesError, match="SyntaxError"):
            registry.use(argument)
        assert sys.modules["broken_toy"] is former
        assert registry.load(TOY, "broken_toy:Law").number == 1
    written(folder / "broken_toy.py", "class Law: number = 2\n")
    registry.use(argument)
    assert registry.load(TOY, "broken_toy:Law").number == 2


def test_the_program_itself_is_never_imported_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = ModuleType("__main__")
    program.__file__ = written(folder / "program.py")
    monkeypatch.setitem(sys.modules, "__main__", program)
    registry.use("__main__")
    written(folder / "program.py", "1 / 0")
    registry.use("__main__")
    assert sys.modules["__main__"] is program
    registry.withdraw("__main__")
