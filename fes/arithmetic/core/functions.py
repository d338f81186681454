"""The compiled elementary functions and random numbers: each repeats its numpy twin to the bit, without warnings."""

import ctypes
import hashlib
from collections.abc import Callable
from ctypes import addressof, c_char, c_double, c_int64, c_uint64, c_void_p
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fes.arithmetic.core import library
from fes.arrays.types import Floats, Ints

NAME = "elementary"

EXPECTED = "d87bb0dc0d18"
"""Hash of the results of the self-test."""

_UNARY = ("exp", "one_minus_exp", "log", "log1p", "log_sum_exp", "wrap")
"""Functions of one number."""

_SIGNATURES: dict[str, list[Any]] = {
    **{name: [c_int64, c_void_p, c_void_p] for name in _UNARY},
    "sin_cos": [c_int64, c_void_p, c_void_p, c_void_p],
    "atan2": [c_int64, c_void_p, c_void_p, c_void_p],
    "power": [c_int64, c_void_p, c_double, c_void_p],
    "product": [c_int64, c_void_p, c_int64, c_void_p],
    "real_power": [c_int64, c_void_p, c_void_p, c_void_p],
    "uniform": [c_int64, c_uint64, c_uint64, c_int64, c_void_p, c_void_p, c_void_p],
}


class Functions:
    """The functions of a library, with the arguments and the shapes of `fes.arithmetic.elementary`."""

    def __init__(self, loaded: ctypes.CDLL) -> None:
        self._call: dict[str, Callable[..., None]] = {}
        for name, arguments in _SIGNATURES.items():
            function = getattr(loaded, f"fes_each_{name}")
            function.argtypes, function.restype = arguments, None
            self._call[name] = function

    def _each(self, name: str, x: Floats) -> Floats:
        values = _numbers(x)
        result = np.empty(values.shape)
        self._call[name](values.size, _address(values), _address(result))
        return _as_numpy(result)

    def exp(self, x: Floats) -> Floats:
        """e^x, any shape."""
        return self._each("exp", x)

    def one_minus_exp(self, a: Floats) -> Floats:
        """1 - e^-a for a >= 0, any shape."""
        return self._each("one_minus_exp", a)

    def exp_and_rise(self, x: Floats, a: Floats) -> tuple[Floats, Floats]:
        """e^x and 1 - e^-a of equal shapes."""
        return self._each("exp", x), self._each("one_minus_exp", a)

    def log(self, x: Floats) -> Floats:
        """The natural logarithm, any shape."""
        return self._each("log", x)

    def log1p(self, x: Floats) -> Floats:
        """log(1 + x), any shape."""
        return self._each("log1p", x)

    def log_sum_exp(self, z: Floats) -> Floats:
        """log(1 + e^z), any shape."""
        return self._each("log_sum_exp", z)

    def sin_cos(self, x: Floats) -> tuple[Floats, Floats]:
        """sin(x) and cos(x), any shape."""
        values = _numbers(x)
        sine, cosine = np.empty(values.shape), np.empty(values.shape)
        self._call["sin_cos"](values.size, _address(values), _address(sine), _address(cosine))
        return _as_numpy(sine), _as_numpy(cosine)

    def atan2(self, y: Floats, x: Floats) -> Floats:
        """The angle of (x, y), shapes that broadcast."""
        return self._both("atan2", y, x)

    def power(self, x: Floats, y: float) -> Floats:
        """x^y for x >= 0 of any shape and one exponent."""
        values = _numbers(x)
        result = np.empty(values.shape)
        self._call["power"](values.size, _address(values), y, _address(result))
        return _as_numpy(result)

    def product(self, x: Floats, n: int) -> Floats:
        """x^n for n >= 0."""
        values = _numbers(x)
        result = np.empty(values.shape)
        self._call["product"](values.size, _address(values), n, _address(result))
        return _as_numpy(result)

    def real_power(self, x: Floats, y: Floats | float) -> Floats:
        """x^y for normal positive x, shapes that broadcast."""
        return self._both("real_power", x, np.asarray(y, dtype=np.float64))

    def random_numbers(self, key: Ints, tick: int, senders: Ints, receivers: Ints) -> Floats:
        """Uniform numbers in [0, 1) of a tick for each (sender, receiver) [m]."""
        low, high = (np.ascontiguousarray(ids, dtype=np.int64) for ids in (senders, receivers))
        result = np.empty(len(low))
        words = int(key[0]), int(key[1])
        self._call["uniform"](len(low), *words, tick, _address(low), _address(high), _address(result))
        return result

    def _both(self, name: str, first: Floats, second: Floats) -> Floats:
        a, b = (_numbers(values) for values in np.broadcast_arrays(first, second))
        result = np.empty(a.shape)
        self._call[name](a.size, a.ctypes.data, b.ctypes.data, _address(result))
        return _as_numpy(result)


@cache
def load() -> Functions | None:
    """The functions of the compiled core; None where numpy computes."""
    loaded = library.load(__file__, NAME, lambda loaded: digest(Functions(loaded)) == EXPECTED)
    return None if loaded is None else Functions(loaded)


def digest(functions: Any) -> str:
    """Hash of the results of all functions over 100 samples each, of all magnitudes."""
    count = np.arange(100)
    share = (count * 2_654_435_761 % 2**32 + 0.5) / 2**32
    wide = np.ldexp(share, count % 80 - 40)
    signed = np.concatenate([wide, -wide, [0.0, np.inf, -np.inf, 709.9, -745.2, 1e300]])
    positive = np.abs(signed[:200])
    results = [
        functions.exp(signed),
        functions.one_minus_exp(positive),
        functions.log(positive),
        functions.log1p(-share),
        functions.log_sum_exp(signed),
        *functions.sin_cos(signed[:200]),
        functions.atan2(signed[:200], signed[199::-1]),
        *(functions.power(positive, exponent) for exponent in (3.0, 2.5, 1.7)),
        functions.random_numbers(np.array([12, 34]), 5, count, count[::-1]),
    ]
    finite = (np.where(np.isnan(values), 0.5, values).astype("<f8").tobytes() for values in results)
    return hashlib.sha256(b"".join(finite)).hexdigest()[:12]


def _numbers(x: Floats) -> Floats:
    """The numbers one after the other, as the library takes them."""
    return np.asarray(x, dtype=np.float64, order="C")


def _address(values: NDArray[Any]) -> int:
    """The address of contiguous values that no broadcast has made; numpy's own way to it takes twice as long."""
    if not values.size or not values.flags.writeable:
        return values.ctypes.data
    return addressof(c_char.from_buffer(values))  # type: ignore[arg-type]


def _as_numpy(result: Floats) -> Floats:
    """A result, without an axis as a number: as numpy returns it."""
    return result[()] if result.ndim == 0 else result
