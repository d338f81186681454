"""Installation advice: it names a clone or a wheel file, never a name that belongs to another project."""

import re
import sys
from pathlib import Path

import pytest

from console.analysis import figures
from console.doctor import machine, network
from console.foxglove import server
from console.sweep import cluster, table
from console.sweep.table import Format
from fes.errors import FesError
from fes.system import distribution
from fes.transport import identity
from tests.support.paths import ROOT, tracked

INSTALLERS = re.compile(
    r"\b(?:pip3?|pipx|uvx?|conda|poetry)\b[^\n|&;`#]*?"
    r"\b(?:install|add|run|download|tool)\b(?P<rest>[^\n|;&#]*)"
)
BY_NAME = re.compile(r"""(?<![\w./*-])(?:fes|fes[-_]robots)(?:\[[\w,-]*\])?(?=$|[\s'"`),:=<>~!])""")
"""A distribution name that an installer would look up in an index: not part of a path or a file."""


def offences(text: str) -> list[str]:
    """Each command in a text that would install a distribution by name."""
    commands = (match["rest"] for match in INSTALLERS.finditer(text))
    return [rest for rest in commands if BY_NAME.search(rest.replace("in a clone of fes", ""))]


def test_no_file_of_the_project_installs_it_by_name() -> None:
    paths = [path for path in tracked() if path != Path(__file__).resolve()]
    assert len(paths) > 200
    assert {ROOT / "README.md", ROOT / "fes/transport/identity.py"} <= set(paths)
    by_name = {
        path.name: commands
        for path in paths
        if (commands := offences(path.read_text(encoding="utf-8", errors="replace")))
    }
    assert by_name == {}


@pytest.mark.parametrize(
    "text",
    [
        "pip install fes", "pip install 'fes[security]'", "`pip install fes-robots`", "pip install --upgrade fes",
        "python -m pip install -q fes_robots==0.2", "uv tool install fes", "pipx install fes-robots", "uv add fes",
        'install("pip install fes")', "pip3 install numpy fes", "uvx run fes", "pip install fes, then",
    ],
)  # fmt: skip
def test_the_search_finds_installation_by_name(text: str) -> None:
    assert offences(text) != []


@pytest.mark.parametrize(
    "text",
    [
        "pip install -e '.[security]'  # in a clone of fes", "pip install .", "pipx install dist/fes_robots-*.whl",
        "/opt/fes/bin/pip install .", "uv tool install ./fes_robots-0.2.0-py3-none-any.whl",
    ],
)  # fmt: skip
def test_the_search_accepts_installation_from_a_clone_and_from_a_wheel(text: str) -> None:
    assert offences(text) == []


def test_an_error_about_a_missing_extra_contains_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in ("matplotlib", "pyarrow", "distributed", "cryptography", "foxglove"):
        monkeypatch.setitem(sys.modules, module, None)
    messages: dict[str, str] = {"security": str(identity.missing_extra())}
    with pytest.raises(FesError) as plot:
        figures.require()
    with pytest.raises(FesError) as parquet:
        table.require(Format.PARQUET)
    with pytest.raises(FesError) as cluster_, cluster.connected("tcp://127.0.0.1:1"):
        pass
    with pytest.raises(FesError) as foxglove, server.opened(0):
        pass
    messages["foxglove"] = str(foxglove.value)
    messages |= {"plot": str(plot.value), "parquet": str(parquet.value), "cluster": str(cluster_.value)}
    for extra, message in messages.items():
        assert distribution.install(extra) in message
        assert "\n" not in message


def test_install_advice_of_the_doctor_comes_from_one_function() -> None:
    missing, *_ = machine.packages(["no-such-package>=1"])
    assert missing.remedy == distribution.install()
    assert "pip install" not in network.remedy("nothing listens")


def test_only_one_module_has_a_command_that_installs() -> None:
    for package in distribution.PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            if path != ROOT / "fes" / "system" / "distribution.py":
                assert not re.search(r"\b(pip3?|pipx|uv tool) install\b", path.read_text(encoding="utf-8")), path
