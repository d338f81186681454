"""The claims, in turn: `python3 -m tests.compose NAMESPACE [PART...]`.

DOCKER_HOST is an engine in that network namespace.
"""

import json
import os
import re
import sys
import time
import traceback
from typing import Any

from tests.compose import walls
from tests.compose.engine import Beside, Broken, Network, Team, call, claim, output, wait

ROBOTS = 10
SOON = 0.1
"""Largest error of a converged formation [m], as configs/compose.toml expects."""


def static(network: Network) -> None:
    """Compose accepts the file with every profile, and builds the image."""
    for profile in ("plain", "secure", "*"):
        claim(
            call("docker", "compose", "--profile", profile, "config", "-q").returncode == 0, f"config -q: {profile}"
        )
    claim(sorted(services()) == ["agent", "world"], "without a profile: world and agent")
    named = services("--profile", "secure")
    claim(
        len(named) == ROBOTS + 2 and not {"agent", "world"} & set(named), "--profile secure: not the plain team too"
    )
    output("docker", "compose", "build")


def services(*flags: str) -> list[str]:
    """The services of a profile; by default of the one in `.env`."""
    return output("docker", "compose", *flags, "config", "--services").split()


def formation(network: Network) -> None:
    """`docker compose up --build`: the formation, with a crash, a partition and an observer."""
    team = Team("plain", "world", FES_RTF="3", FES_FLAGS="--duration 150")
    up = team.beside("up", "--build", "--no-color")
    all_here(team)
    seen = team.compose("run", "--rm", "-T", "dashboard", "fes", "doctor", "-e", "tcp/world:7447", "--json")
    alive = next(one["seen"] for one in json.loads(seen[seen.index("[") :]) if one["check"] == "alive")
    claim("robots 0-9 of 10" in alive, f"fes doctor: {alive}")
    walls.hardened(team, "agent")
    walls.closed(team, network, "agent", 7447)
    crash(team)
    partition(team, network)
    dashboard = team.beside("run", "--rm", "-T", "dashboard")
    code, said = up.end()
    claim(code == 0, "docker compose up: exit code 0")
    claim("summary: largest separation error" in said, "the summary is in the log")
    reached(team, "plain", 150.0)
    watched(dashboard)
    team.end()


def all_here(team: Team) -> None:
    """All robots joined, and all containers are healthy."""
    wait("all robots are here", lambda: "all robots are here" in team.attempt("logs", team.world).stdout)
    wait("all containers are healthy", lambda: all(health(one) == "healthy" for one in team.containers()))


def health(container: dict[str, Any]) -> str:
    """Result of the health check; healthy for ended containers without one."""
    found: str = container["State"].get("Health", {"Status": "healthy"})["Status"]
    return found


def crash(team: Team) -> None:
    """A killed agent restarts by itself, and the run waits for no robot."""
    container, robot = victim(team, 0)
    output("kill", "-9", str(container["State"]["Pid"]))
    away_and_back(team, robot, "its agent was killed")
    again = json.loads(output("docker", "inspect", container["Id"]))[0]
    claim(again["RestartCount"] > 0, "the engine started it again")


def partition(team: Team, network: Network) -> None:
    """A disconnected container is excluded, and rejoins when it is connected again."""
    container, robot = victim(team, 1)
    addresses = [one["IPAddress"] for one in container["NetworkSettings"]["Networks"].values()]
    rules = [("DOCKER-USER", way, address, "-j", "DROP") for address in addresses for way in ("-s", "-d")]
    for rule in rules:
        network.call("iptables", "-I", *rule)
    wait(f"robot {robot} is disconnected and excluded", lambda: news(team, robot)[-1:] == ["not there"])
    dropped = re.findall(r"^ *([1-9]\d*) +\d+ DROP", network.call("iptables", "-vnL", "DOCKER-USER"), re.MULTILINE)
    claim(len(dropped) > 0, "the cut has dropped packets")
    for rule in rules:
        network.call("iptables", "-D", *rule)
    wait(f"robot {robot} is back", lambda: news(team, robot)[-1:] == ["back"])


def victim(team: Team, which: int) -> tuple[dict[str, Any], int]:
    """An agent's container, and its robot."""
    agents = [one for one in team.containers() if one["Config"]["Labels"]["com.docker.compose.service"] == "agent"]
    container = sorted(agents, key=lambda one: one["Name"])[which]
    return container, hosted(output("docker", "logs", container["Id"]))[-1]


def hosted(log: str) -> list[int]:
    """Robots that the agents host, by their logs."""
    return [int(robot) for robot in re.findall(r"agent\.(\d+): ready", log)]


def news(team: Team, robot: int) -> list[str]:
    """Exclusions and rejoins of a robot in the world's log."""
    return re.findall(rf"robot {robot} is (not there|back) from tick", team.log(team.world))


def away_and_back(team: Team, robot: int, why: str) -> None:
    """Wait until a robot is excluded, then rejoins."""
    wait(f"robot {robot} is excluded and rejoins: {why}", lambda: news(team, robot) == ["not there", "back"])


def reached(team: Team, run: str, simulated: float) -> dict[str, Any]:
    """Every container exited with 0, and the summary on the volume is of a converged formation."""
    ends = {one["Name"]: one["State"]["ExitCode"] for one in team.containers()}
    claim(set(ends.values()) == {0}, f"all {len(ends)} containers: exit code 0")
    found = team.summary(run)
    whole = found["robots"] == ROBOTS and abs(found["simulated_s"] - simulated) < 1e-6
    claim(whole, f"summary.json: {found['robots']} robots, {found['simulated_s']:g} s")
    for error in ("separation_error_max", "estimate_error_max"):
        claim(found[error] < SOON, f"summary.json: {error} is {found[error]:.4f} m")
    holds = [one["holds"] for one in found["expectations"]]
    claim(len(holds) > 0 and all(holds), "the scenario's expectations hold")
    return found


def watched(dashboard: Beside) -> None:
    """A dashboard ends with its world, and leaves the last frame."""
    code, said = dashboard.end()
    frame = re.search(r"tick ([\d,]+) / ([\d,]+)", said)
    seen, whole = (int(ticks.replace(",", "")) for ticks in frame.groups()) if frame else (0, -1)
    if code != 0 or whole - seen > 1 or f"{ROBOTS}/{ROBOTS}" not in said:
        raise Broken(f"the dashboard ends with exit code {code} and this:\n{said}")
    claim(True, f"the dashboard sees {ROBOTS} robots, and leaves the last frame, of tick {seen}")


def verdict(network: Network) -> None:
    """A formation that does not converge has exit code 2, and agents wait for a slow world."""
    late = {"COMPOSE_FILE": "compose.yaml:tests/compose/late.yaml"}
    team = Team("plain", "world", FES_RTF="max", FES_FLAGS="--duration 5", FES_OUT="short", **late)
    team.compose("up", "-d")
    claim(True, "docker compose up waits for a world that listens after 12 s")
    waited = team.attempt("wait", "world")
    claim(waited.returncode == 2, "docker compose wait world: exit code 2 after 5 s of a scenario that expects more")
    holds = {one["of"]: one["holds"] for one in team.summary("short")["expectations"]}
    claim(
        holds == {"separation_error_max": False, "estimate_error_max": True}, "summary.json: only estimates are there"
    )
    team.end()


def scale(network: Network) -> None:
    """`--scale agent=N`: another team, fewer agents during the run, the full team again; then a stop."""
    flags = "--set robots.count=12 --duration 3600"
    team = Team("plain", "world", FES_SCENARIO="hundred", FES_FLAGS=flags, FES_OUT="scaled")
    team.compose("up", "-d", "--wait", "--scale", "agent=12")
    all_here(team)
    claim(sorted(hosted(team.log("agent"))) == list(range(12)), "twelve agents lease robots 0 to 11, one each")
    team.compose("up", "-d", "--no-recreate", "--scale", "agent=9")
    wait("three robots are excluded", lambda: tally(team) == (3, 0))
    team.compose("up", "-d", "--no-recreate", "--scale", "agent=12")
    wait("three agents lease them, and they are back", lambda: tally(team) == (3, 3))
    team.compose("stop")
    codes = {one["State"]["ExitCode"] for one in team.containers()}
    claim(codes == {0}, "docker compose stop: everybody ends with exit code 0")
    found = team.summary("scaled")
    claim(found["robots"] == 12 and 0.0 < found["simulated_s"] < 3600.0, "the summary has what was reached")
    team.end()


def tally(team: Team) -> tuple[int, int]:
    """Numbers of robots that the world excluded, and that rejoined."""
    said = team.log(team.world)
    return said.count("is not there from tick"), said.count("is back from tick")


def secure(network: Network) -> None:
    """The profile `secure`: TLS, a certificate per role, the same formation."""
    length = ("--duration", "150")
    team = Team("secure", "secure-world", FES_RTF="3", FES_FLAGS=" ".join(length))
    up = team.beside("up", "--no-color")
    wait("all robots are here", lambda: "all robots are here" in team.attempt("logs", team.world).stdout)
    own = team.compose("exec", "-T", "secure-agent-3", "sh", "-c", "cd /keys && find . -type f | sort").split()
    claim(
        own == [f"./robot-3/{file}" for file in ("ca.crt", "robot-3.crt", "robot-3.key")], "a role has its own keys"
    )
    plain = ("-e", "tcp/secure-world:7447", "--timeout", "2")
    said = team.attempt("run", "--rm", "-T", "dashboard", "fes-agent", "--id", "0", *plain)
    claim(
        said.returncode == 1 and "a world with --keys wants tls/" in said.stdout, "who has no certificate stays out"
    )
    dashboard = team.beside("run", "--rm", "-T", "secure-dashboard")
    walls.hardened(team, "secure-agent-3")
    walls.closed(team, network, "secure-agent-3", 7448)
    code, said_by_all = up.end()
    claim(code == 0 and "summary: largest separation error" in said_by_all, "docker compose up: exit code 0, summary")
    claim("dropped a connection: it does not speak TLS" in said_by_all, "the world's log has who stayed out")
    found = reached(team, "secure", 150.0)
    watched(dashboard)
    alone = ("fes", "run", "configs/compose.toml", "--backend", "inprocess", "--no-record", "--json", *length)
    said_alone = team.compose("run", "--rm", "-T", "secure-dashboard", *alone)
    claim(
        json.loads(said_alone[said_alone.index("{") :])["digest"] == found["digest"],
        "one digest: here, and in one loop",
    )
    team.end()


PARTS = (static, formation, verdict, scale, secure)


def main() -> None:
    """Check the claims; exits with 1 at the first that does not hold, and shows the containers' logs."""
    network, parts, begun = Network(sys.argv[1]), {part.__name__: part for part in PARTS}, time.monotonic()
    for part in [parts[name] for name in sys.argv[2:]] or PARTS:
        print(f"compose: [{time.monotonic() - begun:.0f} s] {(part.__doc__ or '').splitlines()[0]}", flush=True)
        try:
            part(network)
        except Exception as error:
            if not isinstance(error, Broken):
                traceback.print_exc()
            print(call("docker", "compose", "--profile", "*", "logs", "--no-color", "--tail", "40").stdout)
            print(call("docker", "ps", "-a").stdout)
            print(f"compose: FAILED: {error}", flush=True)
            os._exit(1)  # an ordinary exit would wait for background commands, which tests/compose/run ends
    print(f"compose: [{time.monotonic() - begun:.0f} s] done", flush=True)


if __name__ == "__main__":
    main()
