"""The folders of tests: modules that share code do so by tests/support, and unit tests start no process."""

import ast
from pathlib import Path

import pytest

from tests.support.paths import ROOT
from tests.support.source import imports, modules

TEST_MODULES = {name: path for name, path in modules("tests").items() if name.rpartition(".")[2].startswith("test_")}
UNIT = {name: path for name, path in TEST_MODULES.items() if name.startswith("tests.unit.")}

OF_PROCESSES = {
    "subprocess", "multiprocessing", "tests.support.processes", "tests.support.commands.call",
    "tests.support.session", "tests.support.hosts", "tests.support.terminals.Terminal",
}  # fmt: skip
"""Imports of a test that starts a program or opens a session."""

EXCEPTIONS = {"tests.unit.console.backends.test_managed_process"}
"""Unit tests whose subject is the start of a process."""


def imported(path: Path) -> set[str]:
    return set(imports(ast.parse(path.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("name", modules("tests", "bench"))
def test_no_module_imports_a_test_module(name: str) -> None:
    assert [word for word in imported(modules("tests", "bench")[name]) if word in TEST_MODULES] == []


@pytest.mark.parametrize("name", UNIT)
def test_a_unit_test_starts_no_program_and_opens_no_session(name: str) -> None:
    assert not imported(UNIT[name]) & OF_PROCESSES or name in EXCEPTIONS


def test_unit_tests_lie_in_folders_that_mirror_the_packages() -> None:
    for name in UNIT:
        folder = ROOT.joinpath(*name.split(".")[2:-1])
        assert folder.is_dir(), name
