"""Impossible endpoints: each has an error line of its own, before anything waits for it."""

import asyncio
import socket
import threading
from pathlib import Path

import pytest

from fes.errors import FesError, TransportError
from fes.transport import addresses, bus, connection_diagnosis
from fes.transport.endpoints import Endpoints
from tests.support.commands import vacant

BAD = {
    "bogus": "not an endpoint like tcp/127.0.0.1:7447: bogus",
    "": "not an endpoint like tcp/127.0.0.1:7447: ",
    "tcp/": "not an endpoint like tcp/127.0.0.1:7447: tcp/",
    "tcp/a b:1": "not an endpoint like tcp/127.0.0.1:7447: tcp/a b:1",
    "foo/127.0.0.1:1": "the protocol of an endpoint is one of tcp, tls, udp, quic, ws, unixsock-stream, unixpipe, "
    "vsock, serial: foo/127.0.0.1:1",
    "TCP/127.0.0.1:1": "the protocol of an endpoint is one of tcp, tls, udp, quic, ws, unixsock-stream, unixpipe, "
    "vsock, serial: TCP/127.0.0.1:1",
    "tcp/127.0.0.1": "an endpoint ends with its port, as tcp/127.0.0.1:7447 does: tcp/127.0.0.1",
    "tcp/127.0.0.1:": "an endpoint ends with its port, as tcp/127.0.0.1:7447 does: tcp/127.0.0.1:",
    "tcp/[::1]": "an endpoint ends with its port, as tcp/127.0.0.1:7447 does: tcp/[::1]",
    "tcp/127.0.0.1:99999": "a port is a number from 1 to 65535: tcp/127.0.0.1:99999",
    "tcp/127.0.0.1:65536": "a port is a number from 1 to 65535: tcp/127.0.0.1:65536",
    "tcp/127.0.0.1:-1": "a port is a number from 1 to 65535: tcp/127.0.0.1:-1",
    "tcp/127.0.0.1:http": "a port is a number from 1 to 65535: tcp/127.0.0.1:http",
    "tcp/127.0.0.1:\u0663": "a port is a number from 1 to 65535: tcp/127.0.0.1:\u0663",
    "tcp/:7447": "an endpoint names a host before its port: tcp/:7447",
    "tcp/::1:7447": "an IPv6 address needs brackets, tcp/[::1]:7447: tcp/::1:7447",
    "tls/fe80::1:7447?rel=1": "an IPv6 address needs brackets, tls/[fe80::1]:7447?rel=1: tls/fe80::1:7447?rel=1",
    "tcp/[lab]:7447": "only an IPv6 address stands in brackets: tcp/[lab]:7447",
    "tcp/[127.0.0.1]:7447": "only an IPv6 address stands in brackets: tcp/[127.0.0.1]:7447",
    "tcp/a..b:7447": "the name of a host is up to 253 letters, 1 to 63 between dots: tcp/a..b:7447",
    f"tcp/{'a' * 64}:1": f"the name of a host is up to 253 letters, 1 to 63 between dots: tcp/{'a' * 64}:1",
}

GOOD = [
    "tcp/127.0.0.1:7447", "tls/lab.example:1", "tcp/[::1]:65535", "tcp/[fe80::1%lo]:1", "udp/10.0.0.1:7447?rel=0",
    "tcp/lab_x:7447#iface=lo", "quic/lab.example.:1", "unixsock-stream//run/fes.sock", "unixpipe/run/fes",
    "vsock/2:1", "serial//dev/ttyUSB0#baudrate=115200", "ws/localhost:80?x=a:b",
]  # fmt: skip


@pytest.mark.parametrize(("endpoint", "line"), BAD.items())
def test_an_impossible_endpoint_is_rejected_with_a_line_of_its_own(endpoint: str, line: str) -> None:
    for connect, listen in (((endpoint,), ()), ((), (endpoint,))):
        with pytest.raises(FesError) as caught:
            Endpoints("client", connect, listen)
        assert str(caught.value) == line


@pytest.mark.parametrize("endpoint", GOOD)
def test_a_valid_zenoh_endpoint_passes(endpoint: str) -> None:
    assert Endpoints("client", (endpoint,)).connect == (endpoint,)


def test_port_zero_can_be_listened_on_but_not_connected_to() -> None:
    assert Endpoints("router", (), ("tcp/127.0.0.1:0",)).listen
    with pytest.raises(FesError, match=r"^nothing can be reached at port 0: tcp/127.0.0.1:0$"):
        Endpoints("client", ("tcp/127.0.0.1:0",))


def test_a_silent_name_server_delays_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: answer.wait(60.0))
    warning = addresses.unresolved("tcp/lab.example:7447", patience=0.05)
    answer.set()
    assert warning == "the name 'lab.example' does not resolve: no name server answers within 0.05 s"


def test_an_address_is_not_looked_up(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("an address was looked up")

    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    assert [addresses.unresolved(endpoint) for endpoint in ("tcp/[::1]:1", "tcp/127.0.0.1:1", "unixpipe/run/x")] == [
        ""
    ] * 3


def test_a_network_that_cannot_be_reached_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def unreachable(*_: object, **__: object) -> None:
        raise OSError(101, "Network is unreachable")

    def silent(*_: object, **__: object) -> None:
        raise TimeoutError("timed out")

    monkeypatch.setattr(socket, "create_connection", unreachable)
    assert connection_diagnosis.complaint("tcp/192.0.2.1:1", {}) == "it cannot be reached: Network is unreachable"
    monkeypatch.setattr(socket, "create_connection", silent)
    assert connection_diagnosis.complaint("tcp/192.0.2.1:1", {}) == "nothing answers there within 2 s"


def test_a_namespace_that_would_make_keys_too_long_is_rejected() -> None:
    ends = Endpoints("client", (vacant(),), settings=(f'namespace:"{"a" * 70_000}"',), timeout=0.1)

    async def join() -> None:
        async with bus.opened(ends):
            pass

    with pytest.raises(FesError, match=r"^Zenoh's setting `namespace` has at most 1000 letters"):
        asyncio.run(join())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{".encode("utf-16"), "is UTF-16 text: save it as UTF-8"),
        ("{/* \u00e9 */}".encode("latin-1"), "is not UTF-8, line 1 has the byte 0xe9: save it as UTF-8"),
        (b'{\n  "mode": ]}', "line 2, column 11: expected array, boolean, null"),
        (b"{", "line 1, column 2: expected identifier or string"),
    ],
)
def test_an_unreadable_configuration_file_is_reported_with_place_and_rule(
    content: bytes, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "zenoh.json5"
    path.write_bytes(content)
    ends = Endpoints("client", (vacant(),), config_file=path, timeout=0.1)

    async def join() -> None:
        async with bus.opened(ends):
            pass

    with pytest.raises(TransportError) as caught:
        asyncio.run(join())
    assert str(caught.value).startswith(f"cannot read the Zenoh configuration {path}: {said}")
