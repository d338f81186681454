"""Beacons lost on the air are counted one for one: multicast between two machines that drop at a fixed rate.

Each machine is a network namespace, and the kernel of the receiver drops by chance on input. A drop on output would
make the sender fail instead.
"""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from field.radio.settings import GROUP, PORT
from tests.support import hosts
from tests.support.hosts import Host, Internet
from tests.support.processes import PATIENCE, until

BEACONS = 1000

RECEIVE = """
import asyncio, json, sys
from field.radio.settings import RadioSettings
from field.radio.socket import Radio

async def main():
    heard, end = [], asyncio.Event()
    settings = RadioSettings(interface="lan0", key=b"key")
    with await Radio.opened(settings, "main", 1, lambda beacon, at: heard.append(beacon.sequence)) as radio:
        asyncio.get_running_loop().add_reader(radio, radio.receive)
        print("ready", flush=True)
        asyncio.get_running_loop().add_reader(sys.stdin, end.set)  # its end: the sender is done
        await end.wait()
        before = -1
        while before != radio.counters.heard:  # until nothing is left in the socket
            before = radio.counters.heard
            radio.receive()
        counters = radio.counters
        print(json.dumps([heard, counters.heard, counters.overflowed, counters.refused]), flush=True)

asyncio.run(main())
"""
"""A robot that prints the numbers of the beacons that it has heard."""

SEND = f"""
import asyncio
from field.radio.settings import RadioSettings
from field.radio.socket import Radio

async def main():
    settings = RadioSettings(interface="lan0", key=b"key")
    with await Radio.opened(settings, "main", 0, lambda beacon, at: None) as radio:
        asyncio.get_running_loop().add_reader(radio, radio.receive)
        for _ in range({BEACONS}):
            radio.send(bytes(100))
            await asyncio.sleep(0.001)
        print(radio.counters.sent, radio.counters.unsent, radio.counters.own, flush=True)

asyncio.run(main())
"""
"""A robot that sends beacons, at twenty times the usual rate."""


def why_not() -> str:
    """Reason why this machine cannot drop beacons at random; empty if it can."""
    if reason := hosts.why_not():
        return reason
    if shutil.which("nft") is None:
        return "there is no nft (Debian: nftables)"
    table = "add table ip t; add chain ip t c { type filter hook input priority 0; }; "
    rules = table + "add rule ip t c numgen random mod 10 < 3 counter drop"
    tried = subprocess.run(["unshare", "--net", "nft", rules], capture_output=True, text=True)
    return f"nft makes no rule: {' '.join(tried.stderr.split())}" if tried.returncode else ""


WHY_NOT = why_not()
pytestmark = pytest.mark.skipif(bool(WHY_NOT), reason=f"loss of beacons: skipped, because {WHY_NOT}")


@pytest.fixture
def net() -> Iterator[Internet]:
    with hosts.internet() as made:
        for name in ("sender", "receiver"):
            made.host(name)
        made.cable("sender", "receiver")
        yield made


def drop(host: Host, percent: int) -> None:
    """Let a machine count the beacons that arrive, and drop a share of them, which it counts too."""
    host.run("nft", "add table ip air; add chain ip air input { type filter hook input priority 0; }")
    beacon = f"ip daddr {GROUP} udp dport {PORT}"
    host.run("nft", f"add rule ip air input {beacon} counter")
    if percent:
        host.run("nft", f"add rule ip air input {beacon} numgen random mod 100 < {percent} counter drop")


def kernel_counts(host: Host) -> list[int]:
    """The packets of each rule of `drop`."""
    words = [*host.enter, "nft", "-j", "list chain ip air input"]
    listed = json.loads(subprocess.run(words, capture_output=True, text=True, timeout=10, check=True).stdout)
    rules = [entry["rule"]["expr"] for entry in listed["nftables"] if "rule" in entry]
    return [part["counter"]["packets"] for rule in rules for part in rule if "counter" in part]


def send_all(net: Internet, where: Path) -> list[Any]:
    """Numbers heard, their count, the overflow of the receiver and what it refused, after BEACONS were sent."""
    logs = {name: where / f"{name}.log" for name in ("receiver", "sender")}
    receiver = net.start("receiver", [sys.executable, "-c", RECEIVE], logs["receiver"])
    until(partial(_is_ready, logs["receiver"]))
    sender = net.start("sender", [sys.executable, "-c", SEND], logs["sender"])
    assert sender.wait(PATIENCE) == 0, logs["sender"].read_text()
    assert logs["sender"].read_text().split()[:2] == [str(BEACONS), "0"]
    receiver.communicate(timeout=PATIENCE)
    assert receiver.returncode == 0, logs["receiver"].read_text()
    result: list[Any] = json.loads(logs["receiver"].read_text().splitlines()[-1])
    return result


def _is_ready(log: Path) -> bool:
    return "ready" in log.read_text()


@pytest.mark.parametrize("percent", [0, 10, 30, 60, 90])
def test_the_beacons_missing_by_their_numbers_are_those_that_the_kernel_dropped(
    net: Internet, tmp_path: Path, percent: int
) -> None:
    drop(net.hosts["receiver"], percent)
    heard, count, overflowed, refused = send_all(net, tmp_path)
    arrived, *dropped = kernel_counts(net.hosts["receiver"])
    assert arrived == BEACONS
    lost = sum(dropped)
    assert abs(lost - BEACONS * percent / 100) <= 80  # five standard deviations of a fair draw
    assert heard == sorted(heard)
    assert set(heard) <= set(range(BEACONS))
    assert len(set(heard)) == len(heard) == count == BEACONS - lost
    assert (overflowed, refused) == (0, {})


def test_a_datagram_of_the_port_that_is_not_for_the_group_stays_out(net: Internet, tmp_path: Path) -> None:
    log = tmp_path / "receiver.log"
    receiver = net.start("receiver", [sys.executable, "-c", RECEIVE], log)
    until(partial(_is_ready, log))
    unicast = f"import socket; s = socket.socket(type=socket.SOCK_DGRAM); s.sendto(b'x', ('10.77.0.2', {PORT}))"
    assert net.start("sender", [sys.executable, "-c", unicast], tmp_path / "unicast.log").wait(PATIENCE) == 0
    receiver.communicate(timeout=PATIENCE)
    assert json.loads(log.read_text().splitlines()[-1]) == [[], 0, 0, {}]


def test_robots_on_one_machine_hear_each_other_and_count_their_own(net: Internet, tmp_path: Path) -> None:
    logs = {name: tmp_path / f"{name}.log" for name in ("receiver", "sender")}
    receiver = net.start("sender", [sys.executable, "-c", RECEIVE], logs["receiver"])
    until(partial(_is_ready, logs["receiver"]))
    assert net.start("sender", [sys.executable, "-c", SEND], logs["sender"]).wait(PATIENCE) == 0
    receiver.communicate(timeout=PATIENCE)
    assert json.loads(logs["receiver"].read_text().splitlines()[-1])[1:] == [BEACONS, 0, {}]
    assert int(logs["sender"].read_text().split()[2]) > 0
