"""Every constant and every structure of the C sources is that of the Python modules."""

import ctypes
import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.control import crew, separation
from agents.core import byte_crew, compiled_crew, constants
from agents.core import structures as robots
from agents.laws import collocation, neighbor_rules, oracle, packet_counting, perturbation
from agents.laws.core.formula_index import Formula
from fes.arithmetic import angle, exact, exponential, logarithm, power, trigonometry
from fes.arrays import geometry
from fes.model import beacon_slots, contacts, sensing
from fes.protocol import wire
from tests.support import kernels
from tests.support.paths import ROOT
from world.simulation import bursts
from world.simulation.core import compiled_world, link_kernels
from world.simulation.core import structures as world

FOLDERS = ("fes/arithmetic/core", "agents/core", "agents/laws/core", "world/simulation/core")
ARITHMETIC = (angle, exact, exponential, logarithm, power, trigonometry)

NAMED: dict[str, dict[str, Any]] = {
    "exact.h": {"ROUND": exact.ROUND, "ROUND_BITS": exact.ROUND_BITS},
    "exponential.h": {
        **{name: getattr(exponential, name) for name in ("PER_LN2", "LN2_HIGH", "LN2_LOW")},
        "EXP_LEAST": exponential.LEAST,
        "EXP_MOST": exponential.MOST,
        "EXP_SERIES": exponential.SERIES,
    },
    "logarithm.h": {"SMALLEST_NORMAL": logarithm.SMALLEST, "LOG_SERIES": logarithm.SERIES},
    "power.h": {
        **{name: getattr(power, name) for name in ("MOST_PRODUCTS", "LARGEST", "MOST_REST")},
        "POWER_LN2_HIGH": power.LN2_HIGH,
        "POWER_LN2_LOW": power.LN2_LOW,
        "POWER_SERIES": power.SERIES,
    },
    "trigonometry.h": {
        "PI": math.pi,
        "TURN": trigonometry.TURN,
        "SINE_SERIES": trigonometry.SINES,
        "COSINE_SERIES": trigonometry.COSINES,
        "ANGLE_SERIES": angle.SERIES,
    },
    "crew.h": {"NEVER": contacts.NEVER, "MAX_NUMBER": sensing.MAX_NUMBER, "MAX_TWIST": sensing.MAX_TWIST},
    "agents/core/links.c": {"FIRST_EXCHANGE_TICKS": crew.FIRST_EXCHANGE_TICKS},
    "measured.c": {
        **{name: getattr(packet_counting, name) for name in ("MIXING", "LOW", "HIGH", "NEAREST", "LEAST_WEIGHT")},
        **{name: getattr(packet_counting, name) for name in ("SPEED", "LEAST_CURVATURE", "FARTHEST")},
        "LEVEL_PRIOR": packet_counting.LEVEL_PRIOR[0],
        "PRIOR_WEIGHT": packet_counting.LEVEL_PRIOR[1],
        "MOST_MISSED": beacon_slots.MOST_MISSED,
    },
    "perturbation.c": {
        "SWEEPS": perturbation.SWEEPS, "MAX_EXTRAPOLATION": perturbation.MAX_EXTRAPOLATION, "LANES": 8
    },
    "separation.c": {"SWEEPS": separation.SWEEPS},
    "agent.c": {
        "FES_NEW_RANGE": byte_crew.NEW_RANGE, "FES_TOO_LITTLE_ROOM": byte_crew.TOO_LITTLE_ROOM, "FES_UNUSUAL": -3
    },
    "wire.c": {
        "MAX_TICK": wire.MAX_TICK - 1, "MAX_ID": wire.MAX_ID, "LARGEST_NUMBER": sys.float_info.max,
        "MAX_DECLARED": sensing.MAX_DECLARED,
    },
    "agents/core/tick.c": {
        "FES_NEW_CONTACTS": 1, "FES_NEW_LINKS": compiled_crew.NEW_LINKS, "FES_FAILED": -1
    },
    "formula_index.c": {
        **{name: getattr(oracle, name) for name in ("NEARLY_ZERO", "LEAST", "LEAST_SPREAD", "MOST_SPREAD")},
        "AT_ONCE": 64,
    },
    "radio.c": {"AT_ONCE": 64},
    "simulation/core/tick.c": {
        "NEW_PAIRS": compiled_world.NEW_PAIRS, "CANDIDATES_TOO_OLD": compiled_world.CANDIDATES_TOO_OLD
    },
    "messages.h": {
        "MAX_TICK": wire.MAX_TICK - 1, "MAX_ID": wire.MAX_ID,
        "MAX_NUMBER": sensing.MAX_NUMBER, "MAX_TWIST": sensing.MAX_TWIST,
    },
    "world.h": {"OPENING_TICKS": sensing.OPENING_TICKS, "WORDS": 4, "UNKNOWN": bursts.UNKNOWN},
}  # fmt: skip
"""Numbers with a name, by the end of the path of their file."""

COUNTED: dict[str, dict[str, int]] = {
    "crew.h": {
        **{name: getattr(geometry, name) for name in ("X", "Y", "HEADING", "LINEAR", "ANGULAR")},
        "POSE": 3, "TWIST": 2, "LOST": sensing.LOST, "DECODED": sensing.DECODED,
        "DISK": constants.RULES[neighbor_rules.Disk], "TWO_NEAREST": constants.RULES[neighbor_rules.TwoNearest],
        "RELATIVE_NEIGHBORHOOD": constants.RULES[neighbor_rules.RelativeNeighborhood],
        **{name: getattr(constants, name) for name in ("ORACLE", "SAMPLED", "POOLED", "ALONE")},
        **{name: getattr(perturbation, name) for name in ("ESTIMATE", "DRIFT", "BASELINE")},
        "ROWS": perturbation.WEIGHT, "NODES": collocation.NODES, "STATISTICS": packet_counting.STATISTICS,
    },
    "wire.h": {"READ": 0, "TOO_LITTLE_ROOM": 1, "UNUSUAL": 2},
    "kernels.c": {name: getattr(kernels, name) for name in (
        "CONTACTS", "RULE", "LINKS", "PULL", "GIVE_WAY", "TWISTS", "SLOW_DOWN", "MEASURED", "MEASURED_SEEK",
        "PERTURBATION_SEEK",
    )},
    "simulation/core/links.c": {name: getattr(link_kernels, name) for name in (
        "DISAGREEMENT", "ESTIMATE_ERROR", "SEPARATION_ERROR", "ESTIMATES",
    )},
    "messages.h": {
        name: getattr(sensing, name) for name in ("MAX_STATISTICS", "MAX_DECLARED", "MAX_LEARNT", "MAX_DETAILS")
    },
    "world.h": {
        **{name: getattr(geometry, name) for name in ("X", "Y", "HEADING", "LINEAR", "ANGULAR")},
        "POSE": 3, "TWIST": 2, "CLOSED": sensing.CLOSED, "LOST": sensing.LOST, "DECODED": sensing.DECODED,
        **{name: getattr(world, name) for name in ("SENT", "HEARD", "DRAWN", "TOTALS")},
        **{name.upper(): number for name, number in compiled_world._MODELS.items()},
    },
}  # fmt: skip
"""Members of enumerations."""

STRUCTURES: dict[tuple[str, str], type[ctypes.Structure]] = {
    ("crew.h", "Step"): robots.Step,
    ("crew.h", "Objective"): robots.Objective,
    ("crew.h", "Method"): robots.Method,
    ("crew.h", "Crew"): robots.Constants,
    ("crew.h", "Beacons"): robots.BeaconArrays,
    ("crew.h", "Input"): robots.Input,
    ("wire.h", "Messages"): robots.Messages,
    ("formula_index.c", "Formula"): Formula,
    ("world.h", "Settings"): world.Settings,
    ("messages.h", "Batch"): world.Batch,
    ("messages.h", "Parts"): world.Parts,
    ("world.h", "Candidates"): world.CandidateList,
    ("simulation/core/tick.c", "Input"): world.Input,
    ("simulation/core/links.c", "Links"): link_kernels.Links,
}


def sources() -> dict[str, str]:
    """Path and text, without comments, of every C file."""
    paths = [path for folder in FOLDERS for path in sorted((ROOT / folder).glob("*.[ch]"))]
    return {str(path): re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL) for path in paths}


def of(path: str, table: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The part of a table for a file."""
    return next((part for end, part in table.items() if path.endswith(f"/{end}")), {})


def number(text: str) -> float:
    """The value of a constant expression of C."""
    plain = re.sub(r"\(i64\)|(?<=[0-9a-f])u\b", "", text)
    assert re.fullmatch(r"[-+*/() <0-9a-fx.]+", plain), text
    return eval(plain)  # type: ignore[no-any-return]


@pytest.mark.parametrize("path", sources(), ids=lambda path: str(Path(path).relative_to(ROOT)))
def test_every_number_with_a_name_is_pythons(path: str) -> None:
    text = sources()[path]
    defined = dict(re.findall(r"^#define (\w+) ([^\n]*[0-9][^\n]*)$", text, re.MULTILINE))
    found: dict[str, Any] = {name: number(value) for name, value in defined.items() if "attribute" not in value}
    for name, values in re.findall(r"static const double (\w+)\[\] = \{([^}]*)\}", text):
        found[name] = [float(value) for value in values.split(",")]
    expected = of(path, NAMED)
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert np.asarray(found[name]).tolist() == np.asarray(value).tolist(), name


@pytest.mark.parametrize("path", sources(), ids=lambda path: str(Path(path).relative_to(ROOT)))
def test_every_member_of_an_enumeration_is_pythons(path: str) -> None:
    found: dict[str, int] = {}
    for members in re.findall(r"enum \{([^}]*)\}", sources()[path]):
        following = 0
        for member in filter(None, map(str.strip, members.split(","))):
            name, _, value = member.partition(" = ")
            found[name] = following = int(value) if value else following
            following += 1
    assert found == of(path, COUNTED)


@pytest.mark.parametrize(
    "path", [path for path in sources() if "arithmetic" in path], ids=lambda path: Path(path).name
)
def test_every_long_number_of_the_arithmetic_is_a_constant_of_python(path: str) -> None:
    known = {math.ldexp(1.0, -53), math.pi, 2.0 * math.pi, math.ldexp(1.0, 54)}
    for module in ARITHMETIC:
        for value in vars(module).values():
            if isinstance(value, float | int | tuple | np.ndarray):
                known |= set(np.ravel(np.asarray(value, dtype=np.float64)).tolist())
    literals = re.findall(r"(?<![\w.])\d+\.\d*(?:e[-+]?\d+)?", sources()[path])
    long = {float(literal) for literal in literals if len(re.sub(r"e.*|\.", "", literal).strip("0")) > 5}
    assert {value for value in long if value not in known and -value not in known} == set()


@pytest.mark.parametrize(("file", "name"), STRUCTURES)
def test_a_structure_has_the_fields_of_its_twin_in_their_order(file: str, name: str) -> None:
    text = next(text for path, text in sources().items() if path.endswith(f"/{file}"))
    # the structure's own braces only: none of them holds another one
    [body] = re.findall(rf"typedef struct \{{([^{{}}]*)\}} {name};", text)
    declared = []
    for declaration in filter(None, map(str.strip, body.split(";"))):
        kind, names = re.fullmatch(r"((?:const )?\w+ )(.*)", declaration, re.DOTALL).groups()  # type: ignore[union-attr]
        for field in map(str.strip, names.split(",")):
            declared.append((field.lstrip("*").removeprefix("const *").partition("[")[0], kind.strip(), "*" in field))
    twin = STRUCTURES[file, name]._fields_
    assert [field for field, *_ in declared] == [field for field, *_ in twin]
    plain = {"double": ctypes.c_double, "i64": ctypes.c_int64, "u64": ctypes.c_uint64}
    for (field, kind, is_pointer), (_, type_, *_) in zip(declared, twin, strict=True):
        if is_pointer or kind == "Index":
            assert type_ is ctypes.c_void_p, field
        elif kind in plain and not issubclass(type_, ctypes.Array):
            assert type_ is plain[kind], field
