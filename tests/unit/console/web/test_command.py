"""The conditions under which a page has controls, and the facts about a run that was started in this folder."""

from pathlib import Path

import pytest

from console.connect import run_directory
from console.connect.run_directory import Address
from console.web import command
from console.web.facts import RunFacts
from fes.transport.endpoints import Endpoints
from tests.support.loop import load
from world.metrics.summary import write_scenario

HERE = "tcp/127.0.0.1:7447"


@pytest.mark.parametrize("endpoint", [HERE, "tcp/localhost:7447", "tcp/[::1]:7447", "ws/127.0.0.7:1"])
def test_a_run_without_certificates_on_this_machine_has_controls(endpoint: str) -> None:
    assert command.may_change(Endpoints("client", (endpoint,)))


@pytest.mark.parametrize(
    "endpoints",
    [
        Endpoints("client", ("tcp/192.168.0.7:7447",)),
        Endpoints("client", ("tcp/0.0.0.0:7447",)),
        Endpoints("client", ("tcp/localhost.example:7447",)),
        Endpoints("client", (HERE, "tcp/robot-1:7447")),
        Endpoints("client", ("tls/127.0.0.1:7447",), security={"transport/link/tls/root_ca_certificate": "ca.crt"}),
        Endpoints("client", (HERE,), config_file=Path("far.json5")),
        Endpoints("client", (HERE,), settings=('connect/endpoints:["tcp/robot-1:7447"]',)),
    ],
    ids=["address", "any address", "name", "two", "certificate", "file", "setting"],
)
def test_any_other_run_has_none_without_the_flag(endpoints: Endpoints) -> None:
    assert not command.may_change(endpoints)


def test_seed_and_index_are_those_of_the_run_at_these_endpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = Path("runs", "measured-1")
    folder.mkdir(parents=True)
    write_scenario(folder, load("measured.toml", run__seed=7))
    run_directory.announce(folder, Address(HERE, "main"))
    here, elsewhere = Endpoints("client", (HERE,)), Endpoints("client", ("tcp/127.0.0.1:7448",))
    assert command.facts_of("main", here) == RunFacts("main in runs/measured-1", 7, "measured")
    for run, endpoints in (("main", elsewhere), ("other", here)):
        assert command.facts_of(run, endpoints) == RunFacts(run)
