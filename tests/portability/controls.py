"""Controls: results that no run uses, but that a setting may change.

A setting without any effect proves nothing. The hashes show whether the loops of numpy, the C library and the linear
algebra round differently than in another process.
"""

import hashlib
import math
import platform
from collections.abc import Iterable
from importlib import import_module
from typing import Any

import numpy as np

from console.doctor import core
from fes.system import fingerprint

FEATURES = ("SSE42", "AVX", "FMA3", "AVX2", "AVX512F", "AVX512_SKX", "X86_V3", "X86_V4", "NEON", "ASIMD")
"""Features of processors that matter here, by numpy's names of all versions."""

LOOPS = (np.log, np.log1p, np.tanh, np.sin, np.arctan, lambda x: np.exp(-x))


def table() -> dict[str, str]:
    """Versions, features, libraries of the compiled core and hashes of results, by name."""
    x = np.ldexp(np.arange(1, 200_004) * 2_654_435_761 % 2**32 + 0.5, np.arange(1, 200_004) % 37 - 62)
    waves = x[:200_002].view(np.complex128)
    few, square = x[:20_000].tolist(), x[: 64 * 64].reshape(64, 64)
    return {
        "machine": f"{platform.machine()}, Python {platform.python_version()}, {' '.join(platform.libc_ver())}",
        "numpy": np.__version__,
        "features": " ".join(name for name in FEATURES if _features().get(name)),
        "core": " ".join(f"{name}={state}" for name, state in core.libraries().items()),
        "fingerprint": fingerprint.table()["fingerprint"],
        "loops": _hash([*(function(x) for function in LOOPS), np.power(x, 0.3), (waves * waves).view(np.float64)]),
        "libm": _hash([function(value) for value in few] for function in (math.exp, math.log, math.sin, math.log1p)),
        "blas": _hash([square @ square, square[:7, :5] @ square[:5, :9], np.linalg.eigvalsh(square + square.T)]),
    }


def _features() -> dict[str, bool]:
    """Every feature known to numpy -> True if it is used."""
    module = import_module("numpy._core._multiarray_umath")
    return dict(getattr(module, "__cpu_features__", {}))


def _hash(results: Iterable[Any]) -> str:
    digest = hashlib.sha256()
    for result in results:
        digest.update(np.asarray(result, dtype="<f8").tobytes())
    return digest.hexdigest()[:12]
