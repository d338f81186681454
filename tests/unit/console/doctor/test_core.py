"""fes doctor: the finding on the compiled core, with the reason where numpy computes."""

import pytest

from console.doctor import core
from console.doctor.finding import Status
from fes.arithmetic.core import library
from fes.errors import FesError
from fes.system import distribution

NAMES = ("elementary", "robots", "formula_index", "world")


@pytest.fixture(autouse=True)
def _unset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(library.VARIABLE, raising=False)


def test_a_core_whose_libraries_all_compute_is_in_order() -> None:
    result = core.core(dict.fromkeys(NAMES, library.C))
    assert (result.check, result.status, result.remedy) == ("core", Status.OK, "")
    assert result.seen.startswith("compiled: elementary, robots, formula_index, world")


def test_a_core_that_was_never_built_is_a_warning_that_names_a_compiler() -> None:
    result = core.core(dict.fromkeys(NAMES, library.NOT_BUILT))
    assert (result.status, result.seen.partition(": ")[2]) == (Status.WARNING, "the compiled core was not built")
    assert "apt-get install gcc libc6-dev" in result.remedy
    assert result.remedy.endswith(distribution.install())


def test_a_library_that_failed_its_self_test_is_named_with_the_reason() -> None:
    wrong = "it computes other digits than numpy: it was compiled wrongly"
    result = core.core({**dict.fromkeys(NAMES, library.C), "world": wrong})
    assert result.status == Status.WARNING
    assert f"the library 'world' is not used: {wrong}" in result.seen
    assert "robots" not in result.seen
    assert result.remedy == f"CC=clang {distribution.install()}"


def test_a_core_that_the_environment_forbids_is_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(library.VARIABLE, "numpy")
    result = core.core()
    assert (result.status, result.remedy) == (Status.OK, "")
    assert "numpy, because FES_CORE is 'numpy'" in result.seen


def test_an_unknown_core_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(library.VARIABLE, "rust")
    with pytest.raises(FesError, match=r"^FES_CORE must be 'c' or 'numpy', got 'rust'$"):
        core.core()


def test_the_check_loads_all_four_libraries() -> None:
    assert set(core.libraries()) >= set(NAMES)
