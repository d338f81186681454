"""Every compiler builds a core whose self-tests pass; one that contracts operations does not."""

import platform
from pathlib import Path

import pytest

import build_core
from tests.support import builds

SETTINGS: dict[str, tuple[str, ...]] = {
    "without optimization": ("-O0",),
    "for the oldest processor": ("-O3", "-DFES_ONE_VERSION"),
    "for this processor": ("-O3", "-march=native", "-DFES_ONE_VERSION"),
}
WRONG = ("-O2", "-ffp-contract=fast", "-march=native", "-DFES_ONE_VERSION")
"""Settings with which a library rounds a product and a sum together."""

CPU = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
HAS_FMA = " fma " in CPU or platform.machine() in ("aarch64", "arm64")
"""True if this processor multiplies and adds with one rounding."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not builds.COMPILERS or not build_core.is_supported(), reason="no C compiler for the core"),
]


@pytest.mark.parametrize("setting", SETTINGS)
@pytest.mark.parametrize("compiler", builds.COMPILERS)
def test_the_libraries_of_every_compiler_pass_their_self_tests(tmp_path: Path, compiler: str, setting: str) -> None:
    built = builds.build(compiler, tmp_path, SETTINGS[setting], without=("-O2",))
    assert builds.digests(built) == builds.EXPECTED


@pytest.mark.skipif(not HAS_FMA, reason="this processor cannot contract a multiplication and an addition")
@pytest.mark.parametrize("compiler", builds.COMPILERS)
def test_no_library_that_was_built_wrongly_passes_its_self_test(tmp_path: Path, compiler: str) -> None:
    built = builds.build(compiler, tmp_path, WRONG, without=("-O2", "-ffp-contract=off"))
    found = builds.digests(built)
    assert [name for name in builds.LIBRARIES if found[name] == builds.EXPECTED[name]] == []
