"""A folder for modules of extensions, which the next test does not find imported."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fes.extension import registry


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A folder whose modules are forgotten afterwards; Python does not find them before `--use`."""
    before, path = set(sys.modules), list(sys.path)
    yield tmp_path
    sys.path[:] = path
    for name in set(sys.modules) - before:
        module = sys.modules[name]
        places = [str(getattr(module, "__file__", "")), *map(str, getattr(module, "__path__", ()))]
        if any(str(tmp_path) in place for place in places):
            del sys.modules[name]
            registry.withdraw(name)


@pytest.fixture
def searched(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same folder, in which Python finds modules."""
    monkeypatch.syspath_prepend(folder)
    return folder
