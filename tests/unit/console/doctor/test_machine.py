"""fes doctor: findings on a machine, with remedies."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.doctor import machine
from console.doctor.finding import Status
from fes.system import fingerprint
from tests.support.arithmetics import OTHER

EXTRAS = [(1, "plot"), (2, "security"), (3, "security"), (4, "dev"), (1, "dev")]


def test_a_missing_and_an_old_package_fail_and_a_missing_extra_does_not() -> None:
    required = ["numpy>=1.0", "no-such-package>=1", "rich>=1000.1", 'no-such-plot>=3; extra == "plot"']
    result, extras = machine.packages(required)
    assert result.status == Status.FAILED
    assert "no-such-package is missing" in result.seen
    assert "is older than 1000.1" in result.seen
    assert "numpy" not in result.seen
    assert (extras.status, extras.seen) == (Status.OK, "plot: not installed")


def test_the_extras_are_one_line_without_developers_tools() -> None:
    wanted = ["numpy>=1.0", *(f'no-such-{number}>=3; extra == "{extra}"' for number, extra in EXTRAS)]
    extras = [
        result for result in machine.packages([*wanted, 'rich>=13; extra == "table"']) if result.check == "extras"
    ]
    assert [result.seen for result in extras] == ["table: installed; plot, security: not installed"]


def test_a_folder_that_cannot_be_written_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert machine.directory(tmp_path).status == Status.OK

    def refuse(*_: Any, **__: Any) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    result = machine.directory(tmp_path)
    assert (result.status, result.remedy != "") == (Status.FAILED, True)
    assert "Read-only file system" in result.seen


def test_a_full_disk_fails_and_a_nearly_full_one_warns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for free, status in ((1 << 40, Status.OK), (1 << 29, Status.WARNING), (1 << 20, Status.FAILED)):
        monkeypatch.setattr("shutil.disk_usage", lambda _, free=free: type("", (), {"free": free}))
        assert machine.directory(tmp_path).status == status


def test_a_clock_that_is_set_while_it_is_watched_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    assert machine.clock(0.01).status == Status.OK
    times = iter([2e9, 2e9 + 60.0])
    monkeypatch.setattr("time.time", lambda: next(times))
    assert machine.clock(0.01).status == Status.WARNING


def test_the_arithmetic_is_that_of_every_other_machine_or_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    result = machine.arithmetic()
    assert (result.status, result.remedy) == (Status.OK, "")
    assert result.seen == (
        f"fingerprint {fingerprint.EXPECTED}, with numpy {np.__version__}: the same digits as on every other machine"
    )
    monkeypatch.setattr(fingerprint, "table", lambda: dict(OTHER))
    result = machine.arithmetic()
    assert (result.status, result.remedy != "") == (Status.WARNING, True)
    assert result.seen == (
        "fingerprint 0123456789ab, with numpy 1.0.0: this machine's digits differ from every other's, "
        f"whose fingerprint is {fingerprint.EXPECTED}"
    )
