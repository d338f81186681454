"""The claims, in sequence: `python3 -m tests.compose NAMESPACE [PART...]`.

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
from tests.compose.engine import BackgroundCommand, Broken, Network, Team, call, claim, output, wait

ROBOTS = 10
TOLERANCE = 0.1
"""Largest errors of a complete formation [m], as configs/compose.toml expects."""


def static(network: Network) -> None:
    """Compose accepts the file with every profile, and builds the image."""
    for profile in ("plain", "secure", "*"):
        claim(
            call("docker", "compose", "--profile", profile, "config", "-q").returncode == 0, f"config -q: {profile}"
        )
    claim(sorted(services()) == ["agent", "world"], "without a profile: world and agent")
    secure_services = services("--profile", "secure")
    claim(
        len(secure_services) == ROBOTS + 2 and not {"agent", "world"} & set(secure_services),
        "--profile secure: not the plain team too",
    )
    output("docker", "compose", "build")


def services(*flags: str) -> list[str]:
    """The services of a profile; by default of the profile in `.env`."""
    return output("docker", "compose", *flags, "config", "--services").split()


def formation(network: Network) -> None:
    """`docker compose up --build`: the formation, through a crash and a partition, with a dashboard."""
    team = Team("plain", "world", FES_RTF="3", FES_FLAGS="--duration 150")
    up = team.start("up", "--build", "--no-color")
    all_ready(team)
    checks = team.compose("run", "--rm", "-T", "dashboard", "fes", "doctor", "-e", "tcp/world:7447", "--json")
    seen = {check["check"]: check["seen"] for check in json.loads(checks[checks.index("[") :])}
    claim("robots 0-9 of 10" in seen["alive"], f"fes doctor: {seen['alive']}")
    claim(seen["core"].startswith("compiled: "), f"fes doctor: {seen['core']}")
    walls.hardened(team, "agent")
    walls.closed(team, network, "agent", 7447)
    crash(team)
    partition(team, network)
    dashboard = team.start("run", "--rm", "-T", "dashboard")
    code, log = up.end()
    claim(code == 0, "docker compose up: exit code 0")
    claim("summary: largest separation error" in log, "the summary is in the log")
    reached(team, "plain", 150.0)
    watched(dashboard)
    team.end()


def all_ready(team: Team) -> None:
    """All robots joined, and all containers are healthy."""
    wait("all robots are here", lambda: "all robots are here" in team.attempt("logs", team.world).stdout)
    wait("all containers are healthy", lambda: all(health(container) == "healthy" for container in team.containers()))


def health(container: dict[str, Any]) -> str:
    """Result of the health check; healthy for an ended container without one."""
    status: str = container["State"].get("Health", {"Status": "healthy"})["Status"]
    return status


def crash(team: Team) -> None:
    """A killed agent restarts by itself, and the run continues without it."""
    container, robot = victim(team, 0)
    output("kill", "-9", str(container["State"]["Pid"]))
    away_and_back(team, robot, "its agent was killed")
    restarted = json.loads(output("docker", "inspect", container["Id"]))[0]
    claim(restarted["RestartCount"] > 0, "the engine restarted its container")


def partition(team: Team, network: Network) -> None:
    """A disconnected robot is excluded, and rejoins after the connection is restored."""
    container, robot = victim(team, 1)
    addresses = [
        network_settings["IPAddress"] for network_settings in container["NetworkSettings"]["Networks"].values()
    ]
    rules = [("DOCKER-USER", way, address, "-j", "DROP") for address in addresses for way in ("-s", "-d")]
    for rule in rules:
        network.call("iptables", "-I", *rule)
    wait(f"robot {robot} is disconnected, and excluded", lambda: news(team, robot)[-1:] == ["absent"])
    dropped = re.findall(r"^ *([1-9]\d*) +\d+ DROP", network.call("iptables", "-vnL", "DOCKER-USER"), re.MULTILINE)
    claim(len(dropped) > 0, "the firewall has dropped packets")
    for rule in rules:
        network.call("iptables", "-D", *rule)
    wait(f"robot {robot} has rejoined", lambda: news(team, robot)[-1:] == ["back"])


def victim(team: Team, index: int) -> tuple[dict[str, Any], int]:
    """The container of an agent, and its robot."""
    agents = [
        victim_container
        for victim_container in team.containers()
        if victim_container["Config"]["Labels"]["com.docker.compose.service"] == "agent"
    ]
    container = sorted(agents, key=lambda victim_container: victim_container["Name"])[index]
    return container, hosted(output("docker", "logs", container["Id"]))[-1]


def hosted(log: str) -> list[int]:
    """The robots of agents, by their logs."""
    return [int(robot) for robot in re.findall(r"agent\.(\d+): ready", log)]


def news(team: Team, robot: int) -> list[str]:
    """Absences and returns of a robot in the world's log."""
    return re.findall(rf"robot {robot} is (absent|back) from tick", team.log(team.world))


def away_and_back(team: Team, robot: int, why: str) -> None:
    """Wait until a robot is excluded, then rejoins."""
    wait(f"robot {robot} is excluded, and rejoins: {why}", lambda: news(team, robot) == ["absent", "back"])


def reached(team: Team, run: str, simulated: float) -> dict[str, Any]:
    """All containers end with success, and the summary on the volume is that of a complete formation."""
    ends = {each["Name"]: each["State"]["ExitCode"] for each in team.containers()}
    claim(set(ends.values()) == {0}, f"all {len(ends)} containers: exit code 0")
    summary = team.summary(run)
    is_complete = summary["robots"] == ROBOTS and abs(summary["simulated_s"] - simulated) < 1e-6
    claim(is_complete, f"summary.json: {summary['robots']} robots, {summary['simulated_s']:g} s")
    for error in ("separation_error_max", "estimate_error_max"):
        claim(summary[error] < TOLERANCE, f"summary.json: {error} is {summary[error]:.4f} m")
    holds = [each["holds"] for each in summary["expectations"]]
    claim(len(holds) > 0 and all(holds), "the scenario's expectations hold")
    return summary


def watched(dashboard: BackgroundCommand) -> None:
    """A dashboard ends with its world, and prints the last frame."""
    code, text = dashboard.end()
    frame = re.search(r"tick ([\d,]+) / ([\d,]+)", text)
    seen, last = (int(ticks.replace(",", "")) for ticks in frame.groups()) if frame else (0, -1)
    if code != 0 or last - seen > 1 or f"{ROBOTS}/{ROBOTS}" not in text:
        raise Broken(f"the dashboard ends with exit code {code} and this:\n{text}")
    claim(True, f"the dashboard sees {ROBOTS} robots, and prints the last frame, of tick {seen}")


def verdict(network: Network) -> None:
    """An incomplete formation is exit code 2, and agents wait for a world that is slow to start."""
    late = {"COMPOSE_FILE": "compose.yaml:tests/compose/late.yaml"}
    team = Team("plain", "world", FES_RTF="max", FES_FLAGS="--duration 5", FES_OUT="short", **late)
    team.compose("up", "-d")
    claim(True, "docker compose up waits for a world that listens after 12 s")
    waited = team.attempt("wait", "world")
    claim(waited.returncode == 2, "docker compose wait world: exit code 2 after 5 s of a scenario that needs more")
    holds = {expectation["of"]: expectation["holds"] for expectation in team.summary("short")["expectations"]}
    claim(
        holds == {"separation_error_max": False, "estimate_error_max": True},
        "summary.json: only the estimates have converged",
    )
    team.end()


def scale(network: Network) -> None:
    """`--scale agent=N`: another team, fewer agents while it runs, all agents again; then a stop."""
    flags = "--set robots.count=12 --duration 3600"
    team = Team("plain", "world", FES_SCENARIO="hundred", FES_FLAGS=flags, FES_OUT="scaled")
    team.compose("up", "-d", "--wait", "--scale", "agent=12")
    all_ready(team)
    claim(sorted(hosted(team.log("agent"))) == list(range(12)), "twelve agents lease robots 0 to 11, one each")
    team.compose("up", "-d", "--no-recreate", "--scale", "agent=9")
    wait("three robots are excluded", lambda: exclusions(team) == (3, 0))
    team.compose("up", "-d", "--no-recreate", "--scale", "agent=12")
    wait("three agents lease them, and they rejoin", lambda: exclusions(team) == (3, 3))
    team.compose("stop")
    codes = {container["State"]["ExitCode"] for container in team.containers()}
    claim(codes == {0}, "docker compose stop: all containers end with exit code 0")
    summary = team.summary("scaled")
    claim(
        summary["robots"] == 12 and 0.0 < summary["simulated_s"] < 3600.0, "the summary is that of the ticks so far"
    )
    team.end()


def exclusions(team: Team) -> tuple[int, int]:
    """Numbers of robots that the world excluded, and admitted again."""
    log = team.log(team.world)
    return log.count("is absent from tick"), log.count("is back from tick")


def secure(network: Network) -> None:
    """The profile `secure`: TLS, a certificate per role, the same formation."""
    length = ("--duration", "90")
    team = Team("secure", "secure-world", FES_RTF="2", FES_FLAGS=" ".join(length))
    up = team.start("up", "--no-color")
    wait("all robots are here", lambda: "all robots are here" in team.attempt("logs", team.world).stdout)
    own = team.compose("exec", "-T", "secure-agent-3", "sh", "-c", "cd /keys && find . -type f | sort").split()
    claim(
        own == [f"./robot-3/{file}" for file in ("ca.crt", "robot-3.crt", "robot-3.key")], "a role has its own keys"
    )
    plain = ("-e", "tcp/secure-world:7447", "--timeout", "2")
    attempt = team.attempt("run", "--rm", "-T", "dashboard", "fes-agent", "--id", "0", *plain)
    claim(
        attempt.returncode == 1 and "a world with --keys wants tls/" in attempt.stdout,
        "an agent without a certificate is rejected",
    )
    dashboard = team.start("run", "--rm", "-T", "secure-dashboard")
    walls.hardened(team, "secure-agent-3")
    walls.closed(team, network, "secure-agent-3", 7448)
    code, log = up.end()
    claim(code == 0 and "summary: largest separation error" in log, "docker compose up: exit code 0, summary")
    claim("dropped a connection: it does not speak TLS" in log, "the world's log names the rejected connection")
    summary = reached(team, "secure", 90.0)
    watched(dashboard)
    alone = ("fes", "run", "configs/compose.toml", "--backend", "inprocess", "--no-record", "--json", *length)
    output_alone = team.compose("run", "--rm", "-T", "secure-dashboard", *alone)
    claim(
        json.loads(output_alone[output_alone.index("{") :])["digest"] == summary["digest"],
        "equal digests of containers and of one process",
    )
    team.end()


PARTS = (static, formation, verdict, scale, secure)


def main() -> None:
    """Check the claims; at the first that does not hold, print the logs of the containers, and exit with 1."""
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
            os._exit(1)  # an ordinary exit would wait for concurrent commands; tests/compose/run ends them
    print(f"compose: [{time.monotonic() - begun:.0f} s] done", flush=True)


if __name__ == "__main__":
    main()
