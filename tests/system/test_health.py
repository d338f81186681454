"""The health check of a container, on real sockets of the loopback interface."""

import socket
import subprocess
import sys

import pytest

from fes.transport import health
from tests.support.paths import ROOT


def check(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "fes.transport.health", *map(str, words)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)


def test_a_port_is_listening_from_listen_to_close_and_is_not_a_connection() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        assert health.healthy("listens", port)
        assert not health.healthy("connected", port)
    assert not health.healthy("listens", port)


def test_a_connection_lasts_until_it_is_closed_and_only_its_client_counts() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with socket.create_connection(("127.0.0.1", port)) as client:
            own = client.getsockname()[1]
            assert health.healthy("connected", port)
            assert not health.healthy("listens", own)
            with server.accept()[0]:
                pass
            assert client.recv(1) == b""  # the other end is closed: half a connection does not count
            assert not health.healthy("connected", port)


def test_the_health_command_answers_by_its_exit_code() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        result = check("listens", port)
    assert (result.returncode, result.stdout) == (0, f"listens {port}: yes\n")
    lost = check("listens", port)
    assert (lost.returncode, lost.stdout) == (1, f"listens {port}: no\n")


@pytest.mark.parametrize("words", [[], ["listens"], ["listens", "http"], ["speaks", "7447"]])
def test_a_failed_health_check_is_not_healthy(words: list[str]) -> None:
    done = check(*words)
    assert done.returncode == 1
    assert done.stderr.startswith("fes.transport.health: error: expects listens PORT or connected PORT")
    assert done.stderr.count("\n") == 1
