"""Other processes' arithmetic: switches that must change nothing, and processes that claim another fingerprint."""

import os
import subprocess
import sys
from pathlib import Path

SWITCHES = [
    {},
    {"NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"},  # numpy's loops, where the processor has AVX-512
    {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"},
    {"NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR"},
    {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4"},  # the C library's functions, where it has FMA
    {"OPENBLAS_CORETYPE": "Prescott"},  # the linear algebra
    {"OPENBLAS_NUM_THREADS": "4", "PYTHONHASHSEED": "1"},
]
"""Environments in which numpy and the C library take other code; some machines know only some of the names."""

OTHER = {"fingerprint": "0123456789ab", "numpy": "1.0.0", "core": "numpy"}
"""Fingerprint table of an arithmetic that no machine has."""

NEWER_NUMPY = "99.0"

_OTHER = f"from fes.system import fingerprint\nfingerprint.table = lambda: dict({OTHER})\n"
_NEWER = f"import numpy\nnumpy.__version__ = '{NEWER_NUMPY}'\n"


def of(environment: dict[str, str]) -> str | None:
    """The fingerprint that a process computes in an environment; None if no process can run there."""
    code = "from fes.system import fingerprint; print(fingerprint.compute())"
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], env=os.environ | environment, capture_output=True, text=True
    )
    return done.stdout.strip() if done.returncode == 0 else None


def another(where: Path) -> dict[str, str]:
    """An environment in which programs claim the arithmetic OTHER."""
    return _at_start(where / "other", _OTHER)


def newer_numpy(where: Path) -> dict[str, str]:
    """An environment in which programs claim NEWER_NUMPY."""
    return _at_start(where / "newer", _NEWER)


def _at_start(folder: Path, code: str) -> dict[str, str]:
    """An environment in which every Python executes some code at its start."""
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(code)
    paths = [str(folder), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {"PYTHONPATH": os.pathsep.join(paths)}
