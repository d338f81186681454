"""Settings: the same program with other loops of numpy, another C library's code, another linear algebra.

Each takes a part of the processor away, as an older one lacks it. Whether it has an effect here is seen afterwards.
"""

from collections.abc import Sequence
from typing import NamedTuple

from fes.arithmetic.core import library
from tests.portability.interpreters import Interpreter

NUMPY, GLIBC, OPENBLAS = "NPY_DISABLE_CPU_FEATURES", "GLIBC_TUNABLES", "OPENBLAS_CORETYPE"

AVX2 = ("X86_V3", "AVX2", "FMA3")
"""Names of loops for AVX2: numpy 2.4 has levels, older ones have features."""

WITHOUT_FMA = "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable"
"""Names of the C library since 2.33, and those before: unknown ones are ignored."""

CORES = ("Haswell", "Zen", "Nehalem", "Prescott")
FEW_CORES = ("Prescott",)
"""Code of the linear algebra, by its names of processors."""

DISPATCHED = (
    "from numpy._core._multiarray_umath import __cpu_dispatch__ as all, __cpu_features__ as used; "
    "print(*(name for name in all if used[name]))"
)
"""Prints the loops of numpy that this processor lets it choose."""


class Setting(NamedTuple):
    """One way to run the program."""

    name: str
    interpreter: Interpreter
    environment: dict[str, str]

    def describe(self) -> str:
        """The environment as words of a shell."""
        return " ".join(f"{key}='{value}'" for key, value in self.environment.items())


def loops(interpreter: Interpreter) -> tuple[list[Setting], list[str]]:
    """Settings that take loops away from numpy, and remarks about those that have nothing to take away."""
    used = interpreter.says(DISPATCHED).split()
    wide = [name for name in used if name == "X86_V4" or name.startswith("AVX512")]
    narrow = [name for name in used if name in AVX2]
    settings, remarks = [], []
    if wide:
        settings.append(_setting(interpreter, "numpy without AVX-512", {NUMPY: " ".join(wide)}))
    else:
        remarks.append(f"{interpreter.name}: numpy uses no AVX-512 on this processor, so nothing can be switched off")
    if narrow:
        settings.append(_setting(interpreter, "numpy without AVX2", {NUMPY: " ".join(wide + narrow)}))
    else:
        remarks.append(f"{interpreter.name}: numpy uses no AVX2 on this processor, so nothing can be switched off")
    return settings, remarks


def of_libraries(interpreter: Interpreter, cores: Sequence[str]) -> list[Setting]:
    """Settings of the C library and of the linear algebra."""
    return [
        _setting(interpreter, "C library without FMA", {GLIBC: WITHOUT_FMA}),
        *(_setting(interpreter, f"OpenBLAS {core}", {OPENBLAS: core}) for core in cores),
    ]


def together(settings: list[Setting]) -> Setting:
    """All at once: the last value of each variable."""
    environment: dict[str, str] = {}
    for setting in settings:
        environment |= setting.environment
    return _setting(settings[0].interpreter, "all of these together", environment)


def plain(interpreter: Interpreter) -> Setting:
    """The interpreter as it is."""
    return Setting(interpreter.name, interpreter, {})


def compiled(interpreter: Interpreter) -> Setting:
    """The compiled core instead of numpy; it fails where a library of it cannot be used."""
    return Setting(f"{interpreter.name}, compiled core", interpreter, {library.VARIABLE: library.C})


def _setting(interpreter: Interpreter, name: str, environment: dict[str, str]) -> Setting:
    return Setting(f"{interpreter.name}, {name}", interpreter, environment)
