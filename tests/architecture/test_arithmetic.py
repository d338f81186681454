"""Operations on the path of the digits: only those that every processor, numpy and C library round in one way."""

import ast
import re
from collections.abc import Iterator

import pytest

from tests.support.paths import ROOT


def words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


PORTABLE = (
    "agents/configuration",
    "agents/control",
    "agents/core",
    "agents/laws",
    "agents/rivals",
    "agents/runtime",
    "fes/arithmetic",
    "fes/arrays",
    "fes/extension",
    "fes/model",
    "fes/protocol",
    "fes/shapes",
    "world/config",
    "world/metrics",
    "world/simulation",
)
"""Folders on the path of digest, Observations, Reports, summary and r*."""

ARRAYS = words(
    """append arange argmax argsort array array_equal asarray ascontiguousarray broadcast_arrays broadcast_to
    concatenate delete diag_indices empty empty_like eye flatnonzero frombuffer full full_like isin ix_ lexsort
    nan_to_num ndarray ones ones_like repeat roll searchsorted split stack swapaxes tile triu_indices unique
    where zeros zeros_like"""
)
"""Functions of numpy that move values, compare them or count."""

ROUNDED_ONCE = words(
    """abs add bincount clip copysign count_nonzero cumsum equal floor fmax fmin frexp isfinite isinf isnan ldexp less
    linspace logical_and logical_or maximum minimum mod multiply negative remainder sign sqrt square
    ufunc"""
)
"""Functions of numpy that are exact or correctly rounded, or apply + - * / one after the other."""

NAMES = words("""bool_ dtype errstate float32 float64 generic iinfo inf int64 nan pi uint64 uint8""")
RANDOM = frozenset({"Philox"})
EXACT = words("ceil copysign frexp inf isfinite isnan ldexp nan pi sqrt")
"""Functions and numbers of `math` that are exact; the rest calls the C library."""

FACTORIES = frozenset({"add", "logical_and", "logical_or", "maximum", "minimum", "multiply"})
"""ufuncs whose methods (reduce, accumulate, outer) are used."""

UNORDERED = frozenset({"cumprod", "dot", "mean", "prod", "std", "var"})
"""Methods whose order of additions depends on the version of numpy, or which call linear algebra."""

ADDED = frozenset({"counts", "due", "edges", "links", "missed", "old"})
"""Objects with a method `sum` that is allowed: `Edges` (an ordered sum), arrays of whole numbers or truth values."""

OWN_MEANS = frozenset({"_period_average", "after", "loss", "now", "self", "sums"})
"""Objects with a method `mean` of the project."""

GENERATOR = words(
    """beta binomial bytes exponential gamma geometric integers jumped lognormal normal permutation permuted poisson
    rayleigh shuffle standard_normal uniform"""
)
"""Methods of numpy's Generator, whose stream may change with its version; raw words of Philox do not change."""

CORE = ("agents/core", "agents/laws/core", "fes/arithmetic/core", "world/simulation/core")
"""Folders that load our own libraries in C: tests compare every function of these with numpy."""

LOADS_THE_CORE = re.compile(rf"({'|'.join(CORE)})/\w+\.py: \d+: (import ctypes|from ctypes import .*)")

LIBRARIES = frozenset({"builtins", "cmath", "ctypes", "random", "scipy", "statistics"})

MODULES = frozenset({"math", "np"})
"""Names that stand only before a dot: another name, or `getattr`, would hide an operation."""

FROM = frozenset({"numpy.typing.NDArray", "operator.is_"})
"""Names that may be imported from numpy and operator."""


def test_the_path_of_the_digits_uses_portable_operations_only() -> None:
    found = [f"{path}: {offence}" for path, tree in sources() for offence in offences(tree)]
    assert not [text for text in found if not LOADS_THE_CORE.fullmatch(text)], "\n".join(found)


def test_only_the_core_calls_functions_in_c() -> None:
    found = [f"{path}: {offence}" for path, tree in sources() for offence in offences(tree)]
    assert {text.split(":")[0].rpartition("/")[0] for text in found} == set(CORE)


@pytest.mark.parametrize(
    "code",
    [
        "np.exp(x)",
        "np.power(x, 2.0)",
        "np.hypot(x, y)",
        "np.interp(x, a, b)",
        "np.linalg.eigvalsh(a)",
        "np.polynomial.legendre.leggauss(5)",
        "np.einsum('ij->i', a)",
        "np.random.default_rng(1)",
        "np.random.Generator(np.random.Philox(1))",
        "np.sum(x)",
        "np.mean(x)",
        "a @ b",
        "a @= b",
        "a.dot(b)",
        "x.mean()",
        "x.sum()",
        "self.values.sum(axis=0)",
        "generator.normal(size=3)",
        "math.exp(x)",
        "math.hypot(x, y)",
        "x**0.5",
        "x**2",
        "2.0**y",
        "x **= 2",
        "pow(x, y)",
        "sum(x)",
        "generator.jumped()",
        "total = sum",
        "map(sum, x)",
        "mean = x.mean",
        "x.cumprod()",
        "module = np",
        "getattr(np, 'exp')(x)",
        "import numpy.linalg",
        "from numpy.linalg import eigvalsh",
        "import operator",
        "from operator import matmul",
        "from builtins import sum",
        "from math import exp",
        "from numpy import exp",
        "import numpy",
        "import scipy.special",
        "from statistics import fmean",
        "np.add.at(a, i, x)",
        "np.exp.reduce(a)",
    ],
)
def test_an_operation_that_processors_round_differently_is_found(code: str) -> None:
    assert list(offences(ast.parse(code)))


@pytest.mark.parametrize(
    "code",
    [
        "np.sqrt(x) + np.add.reduce(x, axis=0)",
        "math.ldexp(1.0, -53)",
        "2**16",
        "10**6",
        "links.sum(force)",
        "np.random.Philox(key=1)",
        "import math",
        "import numpy as np",
        "from numpy.typing import NDArray",
    ],
)
def test_a_portable_operation_is_allowed(code: str) -> None:
    assert not list(offences(ast.parse(code)))


def sources() -> Iterator[tuple[str, ast.Module]]:
    """Path and syntax tree of each module on the path of the digits."""
    for folder in PORTABLE:
        paths = sorted((ROOT / folder).rglob("*.py"))
        assert paths, folder
        for path in paths:
            yield str(path.relative_to(ROOT)), ast.parse(path.read_text(encoding="utf-8"))


def offences(tree: ast.Module) -> Iterator[str]:
    """Line and text of each operation that is not portable."""
    named = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    for node in ast.walk(tree):
        is_bare = isinstance(node, ast.Name) and node.id in MODULES and id(node) not in named
        if is_bare or is_offence(node):
            yield f"{getattr(node, 'lineno', 0)}: {ast.unparse(node)}"


def is_offence(node: ast.AST) -> bool:
    match node:
        case ast.BinOp(op=ast.MatMult()) | ast.AugAssign(op=ast.MatMult() | ast.Pow()):
            return True
        case ast.BinOp(left, ast.Pow(), right):
            return not all(isinstance(side, ast.Constant) and type(side.value) is int for side in (left, right))
        case ast.Name("pow" | "sum"):
            return True
        case ast.Attribute(ast.Name("np"), name):
            return name not in ARRAYS | ROUNDED_ONCE | NAMES | {"random"}
        case ast.Attribute(ast.Attribute(ast.Name("np"), "random"), name):
            return name not in RANDOM
        case ast.Attribute(ast.Attribute(ast.Name("np"), ufunc), method):
            return (method in {"at", "reduceat"} and ufunc not in {"minimum"}) or ufunc not in FACTORIES | NAMES
        case ast.Attribute(ast.Name("math"), name):
            return name not in EXACT
        case ast.Attribute(owner, "sum"):
            return name_of(owner) not in ADDED
        case ast.Attribute(owner, name) if name in UNORDERED:
            return name_of(owner) not in OWN_MEANS
        case ast.Call(ast.Attribute(_, name)):
            return name in GENERATOR
        case ast.Import(names):
            return any(alias.name.split(".")[0] in LIBRARIES or is_renamed(alias) for alias in names)
        case ast.ImportFrom(module=str(module), names=names):
            library = module.split(".")[0]
            if library in {"numpy", "operator"}:
                return any(f"{module}.{alias.name}" not in FROM for alias in names)
            return library in LIBRARIES | {"math"}
    return False


def is_renamed(module: ast.alias) -> bool:
    """True for operator, a part of numpy, and numpy or math under another name than the one that is looked for."""
    if module.name == "operator" or module.name.startswith("numpy."):
        return True
    return {"numpy": "np", "math": None}.get(module.name, module.asname) != module.asname


def name_of(node: ast.expr) -> str:
    """The last name of an expression."""
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
