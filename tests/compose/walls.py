"""Permissions of a container: claims for the containers of either profile."""

import sys

from tests.compose.engine import Broken, Network, Team, claim


def hardened(team: Team, agent: str) -> None:
    """No container runs as root, can write its file system, or has a capability or memory without a limit."""
    containers = team.containers()
    for one in containers:
        host = one["HostConfig"]
        safe = host["ReadonlyRootfs"] and host["CapDrop"] == ["ALL"] and host["Memory"] and host["PidsLimit"]
        if not (safe and "no-new-privileges:true" in host["SecurityOpt"]):
            raise Broken(f"{one['Name']} is not hardened: {host}")
    users = {one["Config"]["User"] for one in containers}
    claim(users == {"10001:10001"}, f"no process is root in any of {len(containers)} containers")
    claim(team.compose("exec", "-T", team.world, "id", "-u") == "10001\n", "nor is the world, once it runs")
    refused = team.attempt("exec", "-T", team.world, "touch", "/srv/configs/new")
    claim("Read-only file system" in refused.stdout, "the file system is read-only")
    limit = (
        "import glob; print(*(open(f).read() for f in glob.glob('/sys/fs/cgroup/**/memory.[lm]*', recursive=True)))"
    )
    said = team.compose("exec", "-T", agent, "python", "-c", limit)
    claim(str(256 << 20) in said.split(), "the kernel holds an agent to its memory")


def closed(team: Team, network: Network, agent: str, port: int) -> None:
    """The world is reachable only from the machine's loopback interface, and no agent reaches other networks."""
    addresses = "{socket.address for socket in health.here() if socket.state == health.LISTEN}"
    listing = f"from fes.transport import health; print(*{addresses})"
    claim(network.call(sys.executable, "-c", listing).split() == ["0100007F"], "nothing listens but on 127.0.0.1")
    reach = f"import socket; socket.create_connection(('127.0.0.1', {port}), 2)"
    network.call(sys.executable, "-c", reach)
    leave = "import socket; socket.create_connection(('192.0.2.1', 80), 2)"
    said = team.attempt("exec", "-T", agent, "python", "-c", leave).stdout
    claim("Network is unreachable" in said, "agents have no way out")
