"""Rules for the files of a release: each broken one is named."""

import tarfile
import zipfile
from pathlib import Path

import pytest

from deploy.wheels import contents
from deploy.wheels.platforms import ANY, GLIBC, PLATFORMS, SOURCE

ELF = b"\x7fELF\x02\x01\x01" + bytes(9) + b"\x03\x00\x3e\x00" + bytes(44)
"""The header of a library of x86-64."""

NAME = "fes_robots-1.0-py3-none-manylinux_2_17_x86_64.manylinux2014_x86_64.whl"


def wheel(path: Path, libraries: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("fes/__init__.py", "")
        for name, content in libraries.items():
            archive.writestr(name, content)
    return path


def whole(content: bytes) -> dict[str, bytes]:
    return dict.fromkeys(contents.LIBRARIES, content)


def test_a_wheel_with_all_libraries_of_its_platform_breaks_no_rule(tmp_path: Path) -> None:
    assert contents.problems(wheel(tmp_path / NAME, whole(ELF + b"GLIBC_2.17")), "linux-x86_64") == []


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (ELF + b"GLIBC_2.34", "it needs version (2, 34) of the system, and the oldest is (2, 17)"),
        (ELF[:18] + b"\xb7" + ELF[19:], "it is for linux-aarch64"),
        (b"text", "not a library of Linux or macOS with 64 bits"),
    ],
)
def test_each_library_that_the_platform_cannot_load_is_named(content: bytes, problem: str, tmp_path: Path) -> None:
    found = contents.problems(wheel(tmp_path / NAME, whole(content)), "linux-x86_64")
    assert sorted(found) == sorted(f"{library}: {problem}" for library in contents.LIBRARIES)


def test_a_missing_library_and_another_platforms_name_are_named(tmp_path: Path) -> None:
    found = contents.problems(wheel(tmp_path / "fes_robots-1.0-py3-none-linux_x86_64.whl", {}), "linux-x86_64")
    assert found == ["its name does not have the platform's tags", "its libraries are none"]


def test_a_wheel_for_every_platform_has_no_library(tmp_path: Path) -> None:
    path = wheel(tmp_path / "fes_robots-1.0-py3-none-any.whl", {})
    assert contents.problems(path, ANY) == []
    assert contents.problems(wheel(path, {"world/simulation/core/libworld.so": ELF}), ANY) == [
        "world/simulation/core/libworld.so is compiled"
    ]


def test_a_source_distribution_without_the_files_in_c_breaks_the_rules(tmp_path: Path) -> None:
    with tarfile.open(tmp_path / "fes_robots-1.0.tar.gz", "w:gz") as archive:
        archive.add(Path(__file__), "fes_robots-1.0/fes/arithmetic/core/elementary.c")
        archive.add(Path(__file__), "fes_robots-1.0/team-keys/operator.key")
    found = contents.problems(tmp_path / "fes_robots-1.0.tar.gz", SOURCE)
    named = {"build_core.py is missing", "fes/arithmetic/core/exact.h is missing", "team-keys/operator.key is a key"}
    assert named <= set(found)
    assert "fes/arithmetic/core/elementary.c is missing" not in found


def test_the_tags_of_linux_are_those_of_the_oldest_c_library() -> None:
    oldest = "manylinux_{}_{}".format(*GLIBC)
    assert all(platform.tags[0].startswith(oldest) for platform in PLATFORMS.values() if platform.system == "linux")
