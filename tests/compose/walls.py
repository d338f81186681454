"""Privileges of containers: claims for both profiles."""

import sys

from tests.compose.engine import Broken, Network, Team, claim


def hardened(team: Team, agent: str) -> None:
    """No container runs as root, can write its file system, or has a capability or memory without a limit."""
    containers = team.containers()
    for container in containers:
        host = container["HostConfig"]
        is_safe = host["ReadonlyRootfs"] and host["CapDrop"] == ["ALL"] and host["Memory"] and host["PidsLimit"]
        if not (is_safe and "no-new-privileges:true" in host["SecurityOpt"]):
            raise Broken(f"{container['Name']} is not hardened: {host}")
    users = {container["Config"]["User"] for container in containers}
    claim(users == {"10001:10001"}, f"no user is root in the {len(containers)} containers")
    claim(team.compose("exec", "-T", team.world, "id", "-u") == "10001\n", "the world does not run as root")
    refused = team.attempt("exec", "-T", team.world, "touch", "/srv/configs/new")
    claim("Read-only file system" in refused.stdout, "the file system is read-only")
    limit = (
        "import glob; print(*(open(f).read() for f in glob.glob('/sys/fs/cgroup/**/memory.[lm]*', recursive=True)))"
    )
    limits = team.compose("exec", "-T", agent, "python", "-c", limit)
    claim(str(256 << 20) in limits.split(), "the kernel limits the memory of an agent")


def closed(team: Team, network: Network, agent: str, port: int) -> None:
    """The world is reachable only from the machine's loopback interface, and agents have no route outside."""
    addresses = "{socket.address for socket in health.own_sockets() if socket.state == health.LISTEN}"
    listing = f"from fes.transport import health; print(*{addresses})"
    claim(network.call(sys.executable, "-c", listing).split() == ["0100007F"], "sockets listen only on 127.0.0.1")
    reach = f"import socket; socket.create_connection(('127.0.0.1', {port}), 2)"
    network.call(sys.executable, "-c", reach)
    leave = "import socket; socket.create_connection(('192.0.2.1', 80), 2)"
    attempt = team.attempt("exec", "-T", agent, "python", "-c", leave).stdout
    claim("Network is unreachable" in attempt, "agents have no route outside")
