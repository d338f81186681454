"""Evidence: the files that are hashed for a module, whatever way it is installed."""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fes.extension import evidence, registry
from fes.extension.kinds import FORMATION

LAW = "class Law: pass\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder in which Python finds modules, and whose modules are forgotten afterwards."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]
        registry.withdraw(name)


def sha256(name: str) -> str:
    """The evidence of the class `Law` of a module."""
    return evidence.of(FORMATION, f"{name}:Law").sha256


def test_a_package_that_lies_in_two_folders_is_hashed_in_both(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for part, file in (("first", "other.py"), ("second", "law.py")):
        (folder / part / "shared_space").mkdir(parents=True)
        (folder / part / "shared_space" / file).write_text(LAW)
        monkeypatch.syspath_prepend(folder / part)
    registry.use("shared_space.law")
    seen = {sha256("shared_space.law")}
    for part, file in (("first", "other.py"), ("second", "law.py")):
        (folder / part / "shared_space" / file).write_text(LAW + "# changed\n")
        seen.add(sha256("shared_space.law"))
    assert len(seen) == 3


def test_a_file_that_a_distribution_lists_and_lacks_is_no_error(folder: Path) -> None:
    (folder / "partly_there.py").write_text(LAW)
    information = folder / "partly_there-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: partly-there\nVersion: 1.0\n")
    (information / "top_level.txt").write_text("partly_there\n")
    (information / "RECORD").write_text("partly_there.py,,\ngone.py,,\n")
    importlib.invalidate_caches()
    registry.use("partly_there")
    found = evidence.of(FORMATION, "partly_there:Law")
    assert (found.distribution, found.version) == ("partly-there", "1.0")
    assert len(found.sha256) == 64


def test_the_file_of_a_module_is_hashed_although_its_package_does_not_hold_it(folder: Path) -> None:
    """A package may look for its modules in folders that it adds to its path, and then removes."""
    (folder / "moved").mkdir()
    (folder / "elsewhere").mkdir()
    (folder / "moved" / "__init__.py").write_text(
        "from pathlib import Path\n"
        "__path__.append(str(Path(__file__).parents[1] / 'elsewhere'))\n"
        "from moved import law\n"
        "__path__.pop()\n"
    )
    source = folder / "elsewhere" / "law.py"
    source.write_text(LAW)
    registry.use("moved.law")
    before = sha256("moved.law")
    source.write_text(LAW + "# changed\n")
    assert sha256("moved.law") != before
