"""Layers: which package may import which, proved from the source and in a fresh interpreter."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import fes
from fes import extension
from fes.extension import registry
from fes.extension.kinds import CHANNEL, DYNAMICS, KINDS, METRIC, SEEKING
from fes.model.table import Table
from tests.support.layers import LAYERS, SHELLS
from tests.support.paths import ROOT
from tests.support.source import PACKAGES, arrows, importers, imports, modules, package

FORMULA_READERS = {
    "world.simulation.formula",
    "world.metrics.report_builder",
    "agents.laws.oracle",
    "fes.extension.told_channel",
}
"""Modules that may know the channel's formula; `world.metrics.optimum` has it in decimals. Observers see the true
outage."""
MAPPED = [str(path.parent.relative_to(ROOT)) for top in PACKAGES for path in (ROOT / top).rglob("__init__.py")]
LAWS = {"fes.arithmetic", "fes.arrays", "fes.extension", "fes.model"}
"""Packages of the project that the laws import."""
LAWS_OF_AGENTS = ("agents.configuration.", "agents.laws.", "agents.rivals.")
INTERFACE = "fes/extension"
"""The only package whose `__init__` has more than a docstring: others import names from it."""
LARGEST_FOLDER = 12
LONGEST_FILE = 260


def test_a_package_imports_only_from_the_layers_below_its_own() -> None:
    assert sum(len(layer) for layer in LAYERS) == len(set().union(*LAYERS))
    imported = arrows()
    assert set(imported) == set().union(*LAYERS)
    below: set[str] = set()
    for layer in LAYERS:
        for name in layer:
            assert imported[name] <= below, f"{name} imports {imported[name] - below}"
        below |= layer


def test_agents_and_world_do_not_import_each_other_and_no_package_imports_tests() -> None:
    imported = arrows()
    for first, second in (("agents.", "world."), ("world.", "agents.")):
        for name in imported:
            if name.startswith(first):
                assert not [word for word in imported[name] if word.startswith(second)], name
    assert not importers("tests")


def test_the_laws_import_only_arrays_arithmetic_the_model_and_the_interface_of_extensions() -> None:
    assert arrows()["agents.laws"] == LAWS
    assert arrows()["agents.configuration"] == LAWS | {"fes.shapes"}


@pytest.mark.parametrize("library", ["asyncio", "fes.transport"])
def test_only_the_shells_wait_or_communicate(library: str) -> None:
    imported = {package(name) for name in below_console(importers(library)) if not name.startswith("fes.")}
    assert imported <= set(SHELLS)
    assert {"agents.runtime", "world.server"} <= imported


@pytest.mark.parametrize("folder", MAPPED)
def test_no_folder_holds_more_than_twelve_modules(folder: str) -> None:
    assert len([path for path in (ROOT / folder).glob("*.py") if path.stem != "__init__"]) <= LARGEST_FOLDER


def below_console(names: set[str]) -> set[str]:
    """Modules that can be part of a running agent or world."""
    return {name for name in names if not name.startswith("console.")}


def test_only_the_bus_and_its_session_import_zenoh() -> None:
    assert importers("zenoh") <= {"fes.transport.bus", "fes.transport.foreign", "fes.transport.session"}
    assert importers("fes.transport.session") == {"fes.transport.bus"}


def test_only_the_writer_and_readers_of_logs_import_mcap() -> None:
    assert importers("mcap") == {
        "fes.recording.mcap_file",
        "fes.recording.records",
        "fes.recording.reader",
        "fes.recording.ticks",
    }
    assert importers("mcap.data_stream") == {"fes.recording.records"}
    assert not importers("mcap.stream_reader") | importers("mcap.reader")  # their readers trust stated lengths


def test_only_the_world_and_the_oracle_know_the_channels_formula() -> None:
    # A person's figures may show the formula: nothing of the console runs in an agent or a world.
    assert below_console(importers("fes.model.outage")) == FORMULA_READERS


def test_no_module_imports_the_oracle_and_only_the_kinds_name_it() -> None:
    assert not below_console(importers("agents.laws.oracle"))
    paths = [path for kind in KINDS for path in kind.built_in.values()]
    assert [path for path in paths if path.startswith("agents.laws.oracle:")] == [SEEKING.built_in["oracle"]]
    naming = {name for name, path in modules(*PACKAGES).items() if "agents.laws.oracle:" in path.read_text("utf-8")}
    assert naming == {"fes.extension.kinds"}


def test_every_built_in_extension_is_there_and_has_parameters() -> None:
    for kind in KINDS:
        for name in kind.built_in:
            assert issubclass(registry.load(kind, name).Parameters, Table), (kind.name, name)


def test_the_rivals_import_only_the_public_interface() -> None:
    assert arrows()["agents.rivals"] == {"fes.extension"}
    rivals = {name: path for name, path in modules("agents").items() if name.startswith("agents.rivals.")}
    assert len(rivals) == 6
    for path in rivals.values():
        project = {word for word in imports(ast.parse(path.read_text(encoding="utf-8"))) if word.startswith("fes.")}
        assert {word.rpartition(".")[0] or word for word in project} <= {"fes.extension", "fes"}


def test_the_built_in_laws_that_are_told_the_channel_are_those_that_kinds_lists() -> None:
    for kind in KINDS:
        loaded = {name: registry.load(kind, name) for name in kind.built_in}
        assert {name for name in loaded if getattr(loaded[name], "knows_channel", False)} == kind.model_based


def test_a_built_in_extension_is_on_the_side_that_runs_it() -> None:
    for kind in KINDS:
        side = ("world.",) if kind in (CHANNEL, DYNAMICS, METRIC) else LAWS_OF_AGENTS
        assert [path for path in kind.built_in.values() if not path.startswith(side)] == []


@pytest.mark.parametrize("module", ["agents.control.crew", "agents.process"])
def test_an_agent_starts_without_the_formula_and_without_unused_libraries(module: str) -> None:
    code = f"import sys, {module}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert {module, "numpy"} <= loaded
    unwanted = {"matplotlib", "typer", "mcap", "rich", "world", "console", "agents.laws.oracle", "fes.model.outage"}
    assert not unwanted & loaded


def test_a_crew_without_channel_settings_never_loads_the_formula() -> None:
    code = """
import sys
import numpy as np
from agents.control import crew
from fes.model.config import AgentConfig, FormationConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from fes.errors import FesError
seeking = OracleConfig()
config = AgentConfig(
    dt=0.02, seed=1, objective=ObjectiveConfig(), seeking=seeking, formation=FormationConfig(), channel=None
)
try:
    crew.create(config, np.arange(2))
except FesError as error:
    print("refused:", error)
print(*(name for name in sys.modules if name in ("agents.laws.oracle", "fes.model.outage")))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert lines[0].startswith("refused: seeking law 'oracle' needs the channel")
    assert lines[1:] in ([], [""])


@pytest.mark.parametrize(("name", "path"), modules(*PACKAGES, "tests", "bench").items(), ids=lambda value: str(value))
def test_no_module_is_longer_than_the_limit(name: str, path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST_FILE, name


@pytest.mark.parametrize("folder", sorted({*MAPPED} - {INTERFACE}))
def test_a_packages_init_is_its_docstring_and_nothing_else(folder: str) -> None:
    tree = ast.parse((ROOT / folder / "__init__.py").read_text(encoding="utf-8"))
    assert len(tree.body) == 1 or folder == "fes"  # which offers the Python interface, as the next tests show
    assert ast.get_docstring(tree)


def test_the_interface_of_extensions_exports_what_it_imports_and_its_version() -> None:
    tree = ast.parse((ROOT / INTERFACE / "__init__.py").read_text(encoding="utf-8"))
    imported = [name.name for node in tree.body if isinstance(node, ast.ImportFrom) for name in node.names]
    assert sorted([*imported, "API"]) == extension.__all__ == sorted(extension.__all__)
    assert all(hasattr(extension, name) for name in extension.__all__)


def test_the_only_import_from_below_the_console_is_that_of_the_python_interface_for_type_checkers() -> None:
    assert below_console(importers("console")) == {"fes"}
    tree = ast.parse((ROOT / "fes" / "__init__.py").read_text(encoding="utf-8"))
    checked = [node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    assert {name for name in imports(tree) if name.startswith("console")} == {
        name for node in checked for name in imports(node)
    }


def test_the_interface_names_the_console_in_strings_only_and_loads_it_when_it_is_used() -> None:
    code = "import sys, fes; before = set(sys.modules); fes.load; print(*before, '|', *sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    before, after = (text.split() for text in done.stdout.split("|"))
    assert not {"console", "agents", "world", "numpy"} & set(before)
    assert "console.api.scenarios" in after
    in_strings = {
        name
        for name, path in modules("fes", "agents", "world", "field").items()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and str(node.value).startswith("console.")
    }
    assert in_strings == {"fes", "fes.extension.conformance"}


def test_the_interface_offers_what_it_exports() -> None:
    assert set(fes.__all__) == {"load", "run", "read", "sweep", "Run"} <= set(dir(fes))
    for name in fes.__all__:
        offered = getattr(fes, name)
        assert (package(offered.__module__), offered.__name__) == ("console.api", name)
    unknown = "walk"
    with pytest.raises(AttributeError, match="no attribute 'walk'"):
        getattr(fes, unknown)


@pytest.mark.parametrize("folder", MAPPED)
def test_the_map_in_a_packages_docstring_names_exactly_its_modules(folder: str) -> None:
    tree = ast.parse((ROOT / folder / "__init__.py").read_text(encoding="utf-8"))
    lines = (ast.get_docstring(tree) or "").splitlines()[2:]
    # a line of the map: name, two spaces or more, contents; continuation lines are indented
    mapped = {line.split()[0] for line in lines if line and not line.startswith(" ")}
    packages_within = {path.parent.name for path in (ROOT / folder).glob("*/__init__.py")}
    assert mapped == {path.stem for path in (ROOT / folder).glob("*.py")} - {"__init__"} | packages_within
