"""Emulated machines: a network namespace each, joined by virtual cables.

A namespace lasts as long as a process in it. The first process here waits for the end of its standard input, a pipe
that this process holds. So all namespaces vanish when this process ends in any way, with their names and interfaces.
"""

import itertools
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from bench.size.own_router import SOURCE

TOOLS = ("ip", "unshare", "nsenter")


def why_not() -> str:
    """Reason why this machine cannot emulate others; empty if it can."""
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        return f"there is no {missing[0]}"
    if os.geteuid() != 0:
        return "only root can make network namespaces"
    wanted = "ip link add lan type bridge && ip link add one type veth peer name other"
    tried = subprocess.run(["unshare", "--net", "sh", "-c", wanted], capture_output=True, text=True)
    return f"no network can be made in a namespace: {tried.stderr.strip()}" if tried.returncode != 0 else ""


@dataclass
class Host:
    """A namespace and its processes."""

    name: str
    holder: "subprocess.Popen[bytes]"
    addresses: list[str] = field(default_factory=list)

    @property
    def enter(self) -> list[str]:
        """Prefix that runs a command in the namespace."""
        return ["nsenter", f"--net=/proc/{self.holder.pid}/ns/net", "--"]

    def ip(self, *words: str) -> None:
        """Change its network; raises OSError."""
        self.run("ip", *words)

    def run(self, *words: str) -> None:
        """Run a silent command there; raises OSError with its output."""
        done = subprocess.run([*self.enter, *words], capture_output=True, text=True, timeout=10)
        if done.returncode != 0:
            raise OSError(f"{self.name}: {' '.join(words)}: {done.stderr.strip()}")

    def endpoint(self, network: int = 0) -> str:
        """Endpoint of a router on this machine, as seen from its nth network."""
        return f"tcp/{self.addresses[network]}:7447"


class Internet:
    """Hosts, and cables and switches between them; private addresses, no way to other networks."""

    def __init__(self) -> None:
        self.started: list[subprocess.Popen[str]] = []
        self.hosts: dict[str, Host] = {}
        self._networks = itertools.count()

    def host(self, name: str) -> Host:
        """Add a machine."""
        holder = subprocess.Popen(
            ["unshare", "--net", "sh", "-c", "echo; exec cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert holder.stdout is not None
        self.hosts[name] = made = Host(name, holder)
        holder.stdout.readline()  # from here on it is in its namespace
        made.ip("link", "set", "lo", "up")
        return made

    def switch(self, *names: str) -> None:
        """Join machines, old or new, to one network; each cable has the name of its machine."""
        network = next(self._networks)
        middle = self.host(f"switch {network}")
        middle.ip("link", "add", "lan", "type", "bridge")
        middle.ip("link", "set", "lan", "up")
        for number, name in enumerate(names, start=1):
            host = self.hosts.get(name) or self.host(name)
            self._plug(host, f"lan{network}", middle, name)
            middle.ip("link", "set", "dev", name, "master", "lan", "up")
            self._address(host, f"lan{network}", f"10.77.{network}.{number}")

    def cable(self, first: str, second: str) -> None:
        """Join two machines by a network of their own, `lan<number>` at both ends."""
        network = next(self._networks)
        ends = self.hosts[first], self.hosts[second]
        self._plug(ends[0], f"lan{network}", ends[1], f"lan{network}")
        for number, host in enumerate(ends, start=1):
            self._address(host, f"lan{network}", f"10.77.{network}.{number}")

    def pull(self, name: str, network: int = 0) -> None:
        """Pull the cable of a machine at its switch."""
        self.hosts[f"switch {network}"].ip("link", "set", "dev", name, "down")

    def plug(self, name: str, network: int = 0) -> None:
        """Plug the cable in again."""
        self.hosts[f"switch {network}"].ip("link", "set", "dev", name, "up")

    def start(self, name: str, words: list[str], log: Path) -> "subprocess.Popen[str]":
        """A process on a machine that ends with its standard input; its output goes to `log`."""
        entered = [*self.hosts[name].enter, *words]
        with log.open("w") as out:
            process = subprocess.Popen(
                entered, cwd=log.parent, stdin=subprocess.PIPE, stdout=out, stderr=out, text=True
            )
        self.started.append(process)
        return process

    def router(self, name: str, log: Path, *connect: str) -> None:
        """A router on a machine, linked to others."""
        self.start(name, [sys.executable, "-c", SOURCE, "tcp/0.0.0.0:7447", *connect], log)

    def close(self) -> None:
        """End every process here and on the machines, which removes the machines."""
        for process in self.started:
            if process.poll() is None:
                process.kill()
            process.communicate()
        for host in self.hosts.values():
            host.holder.communicate(timeout=10)

    def _plug(self, first: Host, first_end: str, second: Host, second_end: str) -> None:
        ends = [first_end, "netns", str(first.holder.pid)], [second_end, "netns", str(second.holder.pid)]
        first.ip("link", "add", *ends[0], "type", "veth", "peer", "name", *ends[1])

    def _address(self, host: Host, interface: str, address: str) -> None:
        host.ip("addr", "add", f"{address}/24", "dev", interface)
        host.ip("link", "set", interface, "up")
        host.addresses.append(address)


@contextmanager
def internet() -> Iterator[Internet]:
    """Machines for the length of a block."""
    made = Internet()
    try:
        yield made
    finally:
        made.close()
