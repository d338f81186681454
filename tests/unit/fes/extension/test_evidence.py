"""Evidence: the files that are hashed for a module, for each way of installation."""

import importlib
from pathlib import Path

import pytest

from fes.extension import evidence, registry
from fes.extension.kinds import FORMATION

LAW = "class Law: pass\n"


def sha256(name: str) -> str:
    """SHA-256 of the source of an imported module."""
    return evidence.on_disk(name).sha256


def test_a_package_that_lies_in_two_folders_is_hashed_in_both(
    searched: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for part, file in (("first", "other.py"), ("second", "law.py")):
        (searched / part / "shared_space").mkdir(parents=True)
        (searched / part / "shared_space" / file).write_text(LAW)
        monkeypatch.syspath_prepend(searched / part)
    registry.use("shared_space.law")
    seen = {sha256("shared_space.law")}
    for part, file in (("first", "other.py"), ("second", "law.py")):
        (searched / part / "shared_space" / file).write_text(LAW + "# changed\n")
        seen.add(sha256("shared_space.law"))
    assert len(seen) == 3


def test_a_file_that_a_distribution_lists_and_lacks_is_skipped(searched: Path) -> None:
    (searched / "partly_there.py").write_text(LAW)
    information = searched / "partly_there-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: partly-there\nVersion: 1.0\n")
    (information / "top_level.txt").write_text("partly_there\n")
    (information / "RECORD").write_text("partly_there.py,,\ngone.py,,\n")
    importlib.invalidate_caches()
    registry.use("partly_there")
    found = evidence.on_disk("partly_there")
    assert (found.distribution, found.version) == ("partly-there", "1.0")
    assert len(found.sha256) == 64


def test_the_file_of_a_module_is_hashed_although_its_package_does_not_hold_it(searched: Path) -> None:
    """A package may look for its modules in folders that it adds to its path, and then removes."""
    (searched / "moved").mkdir()
    (searched / "elsewhere").mkdir()
    (searched / "moved" / "__init__.py").write_text(
        "from pathlib import Path\n"
        "__path__.append(str(Path(__file__).parents[1] / 'elsewhere'))\n"
        "from moved import law\n"
        "__path__.pop()\n"
    )
    source = searched / "elsewhere" / "law.py"
    source.write_text(LAW)
    registry.use("moved.law")
    before = sha256("moved.law")
    source.write_text(LAW + "# changed\n")
    assert sha256("moved.law") != before


def test_the_evidence_is_that_of_the_code_in_memory_until_the_module_is_used_again(searched: Path) -> None:
    source = searched / "edited_law.py"
    source.write_text(LAW)
    registry.use("edited_law")

    def noted() -> str:
        return evidence.of(FORMATION, "edited_law:Law", registry.load(FORMATION, "edited_law:Law")).sha256

    first = noted()
    assert first == sha256("edited_law")
    source.write_text(LAW + "# changed\n")
    assert noted() == first
    registry.use("edited_law")
    assert noted() == sha256("edited_law") != first
