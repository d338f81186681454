"""The compiled core, built by a compiler with flags of its own, and the verdicts of the self-tests."""

import ctypes
import shutil
from collections.abc import Iterable
from ctypes import c_int64, c_void_p
from pathlib import Path

import pytest

import build_core
from agents.core import self_test as robots
from agents.laws.core import formula_index
from fes.arithmetic.core import functions
from fes.arithmetic.core.functions import Functions
from world.simulation.core import self_test as world

COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]

LIBRARIES = ("elementary", "robots", "formula_index", "world")

EXPECTED = dict(
    zip(LIBRARIES, (functions.EXPECTED, robots.EXPECTED, formula_index.EXPECTED, world.EXPECTED), strict=True)
)
"""Hash of the results of each library's self-test."""


def build(compiler: str, into: Path, flags: Iterable[str], without: Iterable[str] = ()) -> dict[str, Path]:
    """The libraries by name, built with further flags, and `without` some of those that are usual."""
    kept = [flag for flag in build_core.FLAGS if flag not in without]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build_core, "FLAGS", (*kept, *flags))
        patch.setenv("CC", compiler)
        built = build_core.build(into=into)
    return {path.stem.removeprefix("lib"): path for path in built}


def digests(built: dict[str, Path]) -> dict[str, str]:
    """Hash of the results of each library's self-test."""
    loaded = {name: ctypes.CDLL(str(path)) for name, path in built.items()}
    crew, team = loaded["robots"], loaded["world"]
    crew.fes_crew_layout.restype = crew.fes_crew_tick.restype = c_int64
    crew.fes_crew_layout.argtypes = [c_void_p, c_int64, c_void_p]
    crew.fes_crew_tick.argtypes = [c_void_p, c_void_p, c_void_p, c_int64, c_void_p, c_int64, c_void_p]
    team.fes_world_layout.restype = team.fes_world_tick.restype = c_int64
    team.fes_world_layout.argtypes = [c_int64, c_int64, c_void_p]
    team.fes_world_tick.argtypes = [c_void_p] * 4
    return {
        "elementary": functions.digest(Functions(loaded["elementary"])),
        "robots": robots.digest(crew),
        "formula_index": formula_index.digest(loaded["formula_index"]),
        "world": world.digest(team),
    }
