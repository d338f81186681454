"""The choice between the compiled core and numpy: FES_CORE, and libraries that cannot be used."""

import ctypes
from pathlib import Path

import pytest

from agents.core import compiled_crew
from agents.laws.core import formula_index
from fes.arithmetic.core import functions, library
from fes.errors import FesError
from tests.support import cores
from world.simulation.core import compiled_world

MODULES = {
    functions.NAME: functions,
    compiled_crew.NAME: compiled_crew,
    formula_index.NAME: formula_index,
    compiled_world.NAME: compiled_world,
}


@pytest.fixture(autouse=True)
def _chosen_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Load as in a fresh process, and leave the libraries of this one alone."""
    monkeypatch.setattr(library, "state", {})
    monkeypatch.delenv(library.VARIABLE, raising=False)


def refused(found: ctypes.CDLL) -> bool:
    """A self-test that no library passes."""
    return False


def file_of(name: str) -> Path:
    return Path(str(MODULES[name].__file__)).with_name(f"lib{name}{library.SUFFIX}")


def copied(name: str, where: Path, share: float) -> str:
    """The first part of a library in another folder; returns a module's file beside it."""
    data = file_of(name).read_bytes()
    (where / f"lib{name}{library.SUFFIX}").write_bytes(data[: int(share * len(data))])
    return str(where / "module.py")


def test_a_library_that_was_not_built_leaves_the_work_to_numpy_with_the_reason(tmp_path: Path) -> None:
    assert library.load(str(tmp_path / "module.py"), "elementary", refused) is None
    assert library.state == {"elementary": "it was not built"}


def test_a_library_that_is_demanded_but_was_not_built_is_an_error_of_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(library.VARIABLE, library.C)
    with pytest.raises(FesError) as error:
        library.load(str(tmp_path / "module.py"), "elementary", refused)
    assert str(error.value) == "FES_CORE is 'c', but the library 'elementary' cannot be used: it was not built"


@pytest.mark.parametrize("word", ["C", "numpy ", "yes", "1", "c\nnumpy", "x" * 1000])
def test_another_word_is_refused_in_one_line(word: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(library.VARIABLE, word)
    with pytest.raises(FesError) as error:
        library.choice()
    assert str(error.value) == f"FES_CORE must be 'c' or 'numpy', got {word[:60]!r}"
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("word", "meant"), [(None, ""), ("", ""), ("c", "c"), ("numpy", "numpy")])
def test_the_words_are_c_and_numpy_or_none(word: str | None, meant: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if word is not None:
        monkeypatch.setenv(library.VARIABLE, word)
    assert library.choice() == meant


@pytest.mark.parametrize(
    "text", [b"", b"not a library", b"\x7fELF", b"\x7fELF\x02\x01", b"\x7fELF\x02\x01" + bytes(58)]
)
def test_a_file_of_another_kind_leaves_the_work_to_numpy(tmp_path: Path, text: bytes) -> None:
    (tmp_path / f"libelementary{library.SUFFIX}").write_bytes(text)
    assert library.load(str(tmp_path / "module.py"), "elementary", refused) is None
    assert library.state["elementary"] not in ("", library.C)
    assert "\n" not in library.state["elementary"]


@cores.needs(functions.load())
@pytest.mark.parametrize("name", MODULES)
def test_numpy_computes_where_the_core_is_forbidden(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(library.VARIABLE, library.NUMPY)
    assert MODULES[name].load.__wrapped__() is None
    assert library.state == {name: "FES_CORE is 'numpy'"}


@cores.needs(functions.load())
@pytest.mark.parametrize("word", ["", library.C])
@pytest.mark.parametrize("name", MODULES)
def test_a_library_that_was_built_is_used_and_may_be_demanded(
    name: str, word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(library.VARIABLE, word)
    assert MODULES[name].load.__wrapped__() is not None
    assert library.state == {name: library.C}


@cores.needs(functions.load())
@pytest.mark.parametrize("share", [0.0, 0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize("name", MODULES)
def test_a_library_that_is_cut_off_leaves_the_work_to_numpy(name: str, share: float, tmp_path: Path) -> None:
    module = copied(name, tmp_path, share)
    assert library.load(module, name, refused) is None
    assert library.state[name] == "its file is cut off" or library.state[name].startswith("it cannot be loaded (")


@cores.needs(functions.load())
def test_a_library_of_another_program_lacks_the_functions_and_leaves_the_work_to_numpy(tmp_path: Path) -> None:
    (tmp_path / f"libelementary{library.SUFFIX}").write_bytes(file_of("world").read_bytes())
    module = str(tmp_path / "module.py")
    assert (
        library.load(module, "elementary", lambda found: functions.digest(functions.Functions(found)) == "") is None
    )
    assert library.state["elementary"].startswith("it cannot be loaded (")


@cores.needs(functions.load())
@pytest.mark.parametrize("name", MODULES)
def test_a_library_that_computes_other_digits_leaves_the_work_to_numpy(name: str, tmp_path: Path) -> None:
    assert library.load(copied(name, tmp_path, 1.0), name, refused) is None
    assert library.state[name] == "it computes other digits than numpy: it was compiled wrongly"


@cores.needs(functions.load())
@pytest.mark.parametrize("name", MODULES)
def test_a_library_with_another_hash_than_the_stored_one_is_not_used(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = MODULES[name]
    holder = module if hasattr(module, "EXPECTED") else module.self_test
    monkeypatch.setattr(holder, "EXPECTED", "0123456789ab")
    assert module.load.__wrapped__() is None
    assert "other digits" in library.state[name]
