"""The start of a program: garbage collection waits for the imports, and ignores afterwards what they made."""

import gc
from collections.abc import Iterator

import pytest

from fes import process
from fes.arithmetic.core import library
from fes.errors import FesError


@pytest.fixture(autouse=True)
def unfrozen() -> Iterator[None]:
    yield
    gc.unfreeze()
    gc.enable()


def test_garbage_collection_waits_until_the_imports_are_done() -> None:
    gc.unfreeze()
    with process.loading("fes-agent"):
        assert not gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() > 0


def test_an_error_of_the_core_ends_the_program_in_one_line_and_collection_resumes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit) as ended, process.loading("fes-agent"):
        raise FesError(f"{library.VARIABLE} must be 'c'")
    assert ended.value.code == process.FAILURE
    assert capsys.readouterr().err == f"fes-agent: error: {library.VARIABLE} must be 'c'\n"
    assert gc.isenabled()
