"""The compiled core: what its libraries give and take, who loads them, and what their sources include."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import build_core
from agents.core import structures
from fes.arithmetic.core import library
from tests.support import cores, elf
from tests.support.paths import ROOT
from tests.support.source import importers, modules

EXPORTED = {
    "elementary": {
        f"fes_each_{name}"
        for name in (
            *("exp", "one_minus_exp", "log", "log1p", "log_sum_exp", "wrap", "sin_cos", "atan2"),
            *("power", "product", "real_power", "remainder", "uniform"),
        )
    },
    "robots": {"fes_crew_layout", "fes_crew_tick", "fes_crew_payloads", "fes_agent_tick", "fes_crew_kernel"},
    "formula_index": {"fes_formula_index"},
    "world": {
        *("fes_world_layout", "fes_world_tick", "fes_world_separations", "fes_world_link_errors"),
        *("fes_world_beacons", "fes_world_commands"),
    },
}
"""Every function of a library that another program can call."""

IMPORTED = {"memcpy", "memset", "memcmp", "memmove"}
"""Functions of the C library that the core may call: none that rounds."""

STARTED = {"__cxa_finalize", "__gmon_start__", "_ITM_deregisterTMCloneTable", "_ITM_registerTMCloneTable"}
"""Names of the start of any shared library."""

CHOSEN = {"__cpu_model", "__cpu_indicator_init", "__stack_chk_fail"}
"""Names by which compilers choose code for a processor, and guard their stack."""

SOURCES = sorted(path for name in build_core.LIBRARIES for path in (ROOT / name).parent.glob("*.[ch]"))
LONGEST_SOURCE = 200


def built(name: str) -> Path:
    """The file of a library; skips the test loudly where it was not built, or where its format is another one."""
    path = next(path for path in build_core.libraries(ROOT) if path.stem == f"lib{name}")
    if not path.exists():
        pytest.skip(f"no compiled core: {path} was not built")
    if not path.read_bytes().startswith(elf.MAGIC):
        pytest.skip(f"no ELF file of 64 bits: {path}")
    return path


def loaded_by(code: str, core: str = "") -> list[str]:
    """Lines that a fresh interpreter prints, then the libraries that it has loaded."""
    code = f"{code}\nfrom fes.arithmetic.core import library\nprint(*sorted(library.state))"
    environment = os.environ | {library.VARIABLE: core}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()


def test_every_library_is_known() -> None:
    assert (
        {Path(name).name.removeprefix("lib") for name in build_core.LIBRARIES} == set(EXPORTED) == set(cores.LOADERS)
    )


@pytest.mark.parametrize("name", EXPORTED)
def test_a_library_exports_its_functions_and_nothing_else(name: str) -> None:
    # a function in several versions has a second symbol, which chooses among them
    assert {symbol.removesuffix(".resolver") for symbol in elf.symbols(built(name)).exported} == EXPORTED[name]


@pytest.mark.parametrize("name", EXPORTED)
def test_a_library_calls_no_function_that_rounds(name: str) -> None:
    imported = {symbol.partition("@")[0] for symbol in elf.symbols(built(name)).imported}
    assert imported <= IMPORTED | STARTED | CHOSEN


def test_the_sources_are_there_and_short() -> None:
    assert len(SOURCES) > 20
    assert {
        path.name: count for path in SOURCES if (count := len(path.read_text().splitlines())) > LONGEST_SOURCE
    } == {}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_source_includes_only_integers_strings_and_its_own_headers(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    included = re.findall(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', text, re.MULTILINE)
    own = {str(other.relative_to(ROOT)) for other in SOURCES} | {other.name for other in path.parent.glob("*.h")}
    assert set(included) <= own | {"stdint.h", "string.h"}
    assert not re.findall(r"__builtin_(?!sqrt\b)\w+|\blong double\b|\bfloat\b|#\s*pragma\s+(?!GCC unroll)", text)


def test_the_robots_know_no_word_of_the_channels_formula() -> None:
    for path in (path for path in SOURCES if path.parent == ROOT / "agents" / "core"):
        text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert not re.findall(r"path_?loss|outage|snr|logistic|rayleigh|midpoint", text, re.IGNORECASE), path
        assert not re.findall(r"agents/laws|world/", text), path
    assert not {"path_loss_exponent", "loss", "snr"} & {name for name, *_ in structures.Constants._fields_}


def test_only_the_oracle_imports_the_compiled_formula() -> None:
    found = {name for name in importers("agents.laws.core.formula_index") if not name.startswith("console.")}
    assert found == {"agents.laws.oracle"}
    naming = {
        name
        for name, path in modules("fes", "agents", "world", "field").items()
        if "formula_index" in path.read_text()
    }
    allowed = {"agents.laws.oracle", "agents.laws.core.formula_index", "agents.laws.core"}
    assert naming <= allowed | {"agents.runtime.model_freedom"}


def test_no_robot_imports_the_core_of_the_world() -> None:
    assert not any(name.startswith(("agents.", "fes.")) for name in importers("world.simulation.core"))


CREW = """
import numpy as np
from agents.control import crew
from agents.runtime.crew_run import CrewRun
from agents.runtime.model_freedom import is_model_free
from fes.model.config import AgentConfig, ChannelConfig, FormationConfig, ObjectiveConfig
from fes.model.seeking import MeasuredConfig, OracleConfig
channel, law = {law}
config = AgentConfig(
    dt=0.02, seed=1, objective=ObjectiveConfig(), seeking=law, formation=FormationConfig(), channel=channel
)
import agents.process
run = CrewRun(crew.create(config, np.arange(3)))
print(is_model_free())
"""


def test_robots_that_count_beacons_load_neither_the_formula_nor_the_world() -> None:
    free, libraries = loaded_by(CREW.format(law='None, MeasuredConfig(index="measured")'))
    assert free == "True"
    assert set(libraries.split()) == {"elementary", "robots"}


def test_robots_that_are_told_the_channel_load_the_formula_but_not_the_world() -> None:
    free, libraries = loaded_by(CREW.format(law="ChannelConfig(), OracleConfig()"))
    assert free == "False"
    assert "world" not in libraries.split()


@pytest.mark.parametrize("name", ["formula_index", "world"])
def test_a_process_that_has_loaded_a_library_with_the_formula_is_not_model_free(name: str) -> None:
    built(name)
    code = f"""
from agents.runtime.model_freedom import is_model_free
from fes.arithmetic.core import functions, library
functions.load()
print(is_model_free())
library.state["{name}"] = "c"
print(is_model_free())
library.state["{name}"] = "it was not built"
print(is_model_free())
"""
    assert loaded_by(code)[:3] == ["True", "False", "True"]


def test_the_world_loads_neither_the_robots_nor_their_formula() -> None:
    code = "import world.process, sys\nfrom world.simulation.core import compiled_world\ncompiled_world.load()"
    assert set(loaded_by(code)[-1].split()) == {"elementary", "world"}
