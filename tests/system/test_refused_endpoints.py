"""Impossible endpoints: each command rejects them in one line, without waiting."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.commands import PROGRAMS, call, complaint, vacant
from tests.support.paths import CONFIGS

NAME = "no.such.host.invalid"
"""A name that no name server has: `.invalid` is reserved for this."""

BAD = {
    "tcp/127.0.0.1:99999": "a port is a number from 1 to 65535: tcp/127.0.0.1:99999",
    "tcp/::1:7447": "an IPv6 address needs brackets, tcp/[::1]:7447: tcp/::1:7447",
}


@pytest.mark.parametrize(
    "words",
    [
        ["fes-agent", "--id", "0", "--timeout", "3600", "-e"],
        ["fes-world", str(CONFIGS / "pair.toml"), "-l"],
        ["fes", "view", "--timeout", "3600", "-e"],
        ["fes", "set", "channel.reference_snr=1", "--timeout", "3600", "-e"],
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_every_command_rejects_an_impossible_endpoint_without_waiting(words: list[str], tmp_path: Path) -> None:
    for endpoint, line in BAD.items():
        assert complaint(call(tmp_path, *words, endpoint), words[0]) == line


@pytest.mark.parametrize("key", ["connect", "listen"])
def test_endpoints_of_a_configuration_file_and_of_settings_are_checked_too(key: str, tmp_path: Path) -> None:
    (tmp_path / "zenoh.json5").write_text(json.dumps({key: {"endpoints": ["tcp/127.0.0.1:99999"]}}))
    words = ["fes-agent", "--id", "0", "--timeout", "3600", "-m", "peer"]
    for given in (["-c", "zenoh.json5"], ["--cfg", f'{key}/endpoints:["tcp/127.0.0.1:99999"]']):
        assert complaint(call(tmp_path, *words, *given), "fes-agent") == BAD["tcp/127.0.0.1:99999"]


def test_an_unreachable_endpoint_of_a_configuration_file_is_named(tmp_path: Path) -> None:
    endpoint = vacant()
    (tmp_path / "zenoh.json5").write_text(json.dumps({"connect": {"endpoints": [endpoint]}}))
    done = call(tmp_path, "fes", "set", "channel.reference_snr=1", "--timeout", "0.3", "-c", "zenoh.json5")
    assert complaint(done, "fes") == f"nothing listens on {endpoint} (tried for 0.3 s)"


def test_a_name_that_does_not_resolve_is_reported_at_once_and_at_the_end(tmp_path: Path) -> None:
    endpoint = f"tcp/{NAME}:7447"
    words = [str(PROGRAMS / "fes-agent"), "--id", "0", "--timeout", "4", "-e", endpoint]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as agent:
        assert agent.stderr is not None
        waiting, warning, last = agent.stderr.readline(), agent.stderr.readline(), agent.stderr.readline()
    assert "waiting for the world" in waiting
    why = f"the name '{NAME}' does not resolve: "
    assert f"network: {endpoint}: {why}" in warning
    assert warning.endswith("; trying for 4 s\n")
    assert last.startswith(f"fes-agent: error: cannot join the network at {endpoint}: {why}")
    assert last.endswith(" (tried for 4 s)\n")
    assert agent.returncode == 1


def test_a_listening_address_that_does_not_resolve_is_reported(tmp_path: Path) -> None:
    done = call(tmp_path, "fes-world", str(CONFIGS / "pair.toml"), "-l", f"tcp/{NAME}:7447")
    assert f"fes-world: error: cannot listen on tcp/{NAME}:7447: the name '{NAME}' does not resolve" in done.stderr


def test_a_listening_address_of_another_machine_is_reported(tmp_path: Path) -> None:
    done = call(tmp_path, "fes-world", str(CONFIGS / "pair.toml"), "-l", "tcp/192.0.2.1:7447")
    assert done.stderr.endswith("cannot listen on tcp/192.0.2.1:7447: Cannot assign requested address\n")


@pytest.fixture
def hosts(tmp_path: Path) -> list[str]:
    """Prefix of a command: run it with the file `hosts` as /etc/hosts."""
    (tmp_path / "hosts").write_text("127.0.0.1 localhost\n")
    within = ["unshare", "--mount", "sh", "-c", f'mount --bind {tmp_path}/hosts /etc/hosts && exec "$@"', "sh"]
    if os.geteuid() != 0 or shutil.which("unshare") is None:
        pytest.skip("only root can put another file over /etc/hosts")
    if subprocess.run([*within, "true"], capture_output=True).returncode != 0:
        pytest.skip("no mount namespace can be made here")
    return within


def test_an_agent_joins_once_a_name_resolves(hosts: list[str], tmp_path: Path) -> None:
    """A container may start before the one that it connects to by name: it waits for the name to resolve."""
    endpoint = vacant()
    late = endpoint.replace("127.0.0.1", "late-world.invalid")
    words = [*hosts, str(PROGRAMS / "fes-agent"), "--id", "0", "--timeout", "60", "-e", late]
    scenario = [str(CONFIGS / "pair.toml"), "--set", "robots.poses=[[0.0, 0.0, 0.0]]", "--duration", "0.2"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as agent:
        assert agent.stderr is not None
        agent.stderr.readline()
        assert "does not resolve" in agent.stderr.readline()
        with (tmp_path / "hosts").open("a") as file:
            file.write("127.0.0.1 late-world.invalid\n")
        world = call(tmp_path, "fes-world", *scenario, "-l", endpoint)
        assert world.returncode == 0, world.stderr
        assert agent.stderr.read().endswith("agent.0: the run is over\n")
    assert agent.returncode == 0


@pytest.mark.parametrize("nesting", ["[", "{a:"])
def test_brackets_that_would_crash_zenoh_are_rejected(nesting: str, tmp_path: Path) -> None:
    """Zenoh's parser would overflow the stack, which ends the process with a signal."""
    close = {"[": "]", "{a:": "1}"}[nesting]
    deep = nesting * 50_000 + close[:-1] + close[-1] * 50_000
    (tmp_path / "deep.json5").write_text(f'{{"metadata": {deep}}}')
    words = ["fes-agent", "--id", "0", "-e", vacant(), "--timeout", "0.1"]
    line = complaint(call(tmp_path, *words, "-c", "deep.json5"), "fes-agent")
    assert line == "cannot read the Zenoh configuration deep.json5: has more than 1000 brackets within each other"
    line = complaint(call(tmp_path, *words, "--cfg", f"metadata:{deep[:100_000]}"), "fes-agent")
    assert line.startswith("--cfg metadata:[[[" if nesting == "[" else "--cfg metadata:{a:")
    assert line.endswith("no such setting, or its value is not JSON5")
    assert len(line) < 300


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_a_configuration_file_may_begin_with_a_byte_order_mark(mark: bytes, tmp_path: Path) -> None:
    endpoint = vacant()
    (tmp_path / "zenoh.json5").write_bytes(mark + json.dumps({"connect": {"endpoints": [endpoint]}}).encode())
    done = call(tmp_path, "fes", "set", "channel.reference_snr=1", "--timeout", "0.3", "-c", "zenoh.json5")
    assert complaint(done, "fes") == f"nothing listens on {endpoint} (tried for 0.3 s)"
