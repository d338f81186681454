"""Another arithmetic on this machine: an environment in which the same program rounds differently."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

from fes.system import fingerprint

SWITCHES = [
    {"NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"},  # numpy's loops, where the processor has AVX-512
    {"NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR"},
    {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4"},  # the C library's functions, where it has FMA
    {"OPENBLAS_CORETYPE": "Prescott"},  # the linear algebra
    {"OPENBLAS_CORETYPE": "ARMV8"},
]
"""Each changes something on some machines only."""

OTHER = {"fingerprint": "0123456789ab", "numpy": "1.0.0", "core": "numpy"}
"""Fingerprint table of an arithmetic that no machine has."""


def of(environment: dict[str, str]) -> str:
    """The arithmetic of a process in an environment; this process's own if none can run there."""
    code = "from fes.system import fingerprint; print(fingerprint.text())"
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], env=os.environ | environment, capture_output=True, text=True
    )
    return done.stdout.strip() if done.returncode == 0 else fingerprint.text()


@cache
def _switch() -> dict[str, str] | None:
    """The first switch that changes the arithmetic of this machine."""
    return next((switch for switch in SWITCHES if of(switch) != fingerprint.text()), None)


def another(where: Path) -> dict[str, str]:
    """An environment in which programs have, or on a machine without a switch claim, another arithmetic."""
    if (switch := _switch()) is not None:
        return switch
    (where / "sitecustomize.py").write_text(
        "from fes.system import fingerprint\nfingerprint._fingerprint = lambda: 'other'\n"
    )
    return {"PYTHONPATH": str(where)}
