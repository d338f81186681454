"""Soak test: a team of real processes under random kills, hangs and world restarts.

    python -m tests.support.soak --minutes 10

Ten agents and a world, each a process, are killed (SIGKILL) and suspended (SIGSTOP, SIGCONT) at random times. The
world is also stopped (SIGTERM), and suspended for less than the lease of a session. Every process that dies is
restarted, the world with --resume. Then the faults end, and the run continues to its end.

Pass criteria: every tick is in the log and reexecution has the same digits; every process exits with 0, and none
remains; the formation is kept.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from console.backends.process_group import free_port
from console.replay import command as replay_command
from console.replay import log
from fes.recording.layout import NAME
from tests.support.paths import CONFIGS
from world.config.scenario import load

SCENARIO = CONFIGS / "neighborhood.toml"

PACE = 1.0
"""Simulated seconds per second during faults."""

PEACE = 60.0
"""Least simulated time without faults at the end [s]."""

CALM = (0.5, 4.0)
"""Time between faults [s]."""

AWAY = (0.0, 3.0)
"""Time from a kill to the restart [s]."""

ASLEEP = (0.5, 14.0)
"""Suspensions of an agent [s]: some longer than the world waits."""

DOZE = (0.2, 1.0)
"""Suspensions of the world [s]: shorter than a session's lease of 2 s, so that its sessions survive."""

PATIENCE = 600.0  # s


class Team:
    """The processes, each restarted after its end."""

    def __init__(self, out: Path, minutes: float) -> None:
        self.out = out
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.logs = out / "logs"
        self.logs.mkdir(parents=True)
        self.duration = 60.0 * minutes * PACE + PEACE
        self.robots = load(SCENARIO).robots.number
        self.started: list[subprocess.Popen[bytes]] = []
        words = [str(SCENARIO), "--duration", str(self.duration), "--out", str(out)]
        self.world = self._world(*words, "--rtf", str(PACE))
        self.agents = {robot: self._agent(robot) for robot in range(self.robots)}

    def resume(self, rtf: str) -> None:
        """Start another world that resumes the run."""
        self.world = self._world("--resume", str(self.out), "--rtf", rtf)

    def rejoin(self, robot: int) -> None:
        """Start another agent for a robot."""
        self.agents[robot] = self._agent(robot)

    def end(self) -> None:
        """Kill every remaining process."""
        for process in (self.world, *self.agents.values()):
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()
            process.wait()

    def orphans(self) -> list[str]:
        """Living processes that this team started."""
        return [str(process.args) for process in self.started if process.poll() is None]

    def _world(self, *words: str) -> "subprocess.Popen[bytes]":
        return self._start("world.process", "world", *words, "-l", self.endpoint, "--checkpoint", "2")

    def _agent(self, robot: int) -> "subprocess.Popen[bytes]":
        return self._start(
            "agents.process", f"agent-{robot}", f"--id={robot}", "-e", self.endpoint, f"--timeout={PATIENCE}"
        )

    def _start(self, module: str, name: str, *words: str) -> "subprocess.Popen[bytes]":
        with (self.logs / f"{name}.log").open("ab") as stream:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", module, *words], stdin=subprocess.DEVNULL, stdout=stream, stderr=stream
            )
        self.started.append(process)
        return process


class Trouble:
    """Faults at random times, one or several at once, reproducible from a seed."""

    def __init__(self, team: Team, seed: int) -> None:
        self._team, self._random = team, random.Random(seed)
        self._later: list[tuple[float, str, int]] = []
        """Times, actions and processes that undo a fault."""
        self.counts: Counter[str] = Counter()

    def rage(self, seconds: float) -> None:
        """Inject faults for a while after the first checkpoint, then undo them."""
        while not (self._team.out / "checkpoint" / "state").exists():
            self._look()
            time.sleep(0.02)
        end = time.monotonic() + seconds
        due = time.monotonic() + self._random.uniform(*CALM)
        while time.monotonic() < end:
            if time.monotonic() >= due:
                self._fault()
                due = time.monotonic() + self._random.uniform(*CALM)
            self._undo(time.monotonic())
            self._look()
            time.sleep(0.02)
        while self._later:
            self._undo(time.monotonic())
            self._look()
            time.sleep(0.02)

    def _fault(self) -> None:
        busy = {robot for _, _, robot in self._later}
        robot = self._random.choice([-1, -1, -1, *range(self._team.robots)])
        if robot in busy:
            return
        soon = time.monotonic() + self._random.uniform(*AWAY)
        if robot < 0:
            how = self._random.choice([signal.SIGKILL, signal.SIGTERM, signal.SIGSTOP])
            self._team.world.send_signal(how)
            if how is signal.SIGSTOP:
                self._later.append((time.monotonic() + self._random.uniform(*DOZE), "continue", robot))
                self.counts["worlds suspended"] += 1
                return
            code = self._team.world.wait(PATIENCE)  # -how: of a process that has just started
            self._expect(code in (0, -how), f"the world ended with {code}")
            self._later.append((soon, "resume", robot))
            self.counts["worlds killed" if how is signal.SIGKILL else "worlds told to stop"] += 1
        elif self._random.random() < 0.5:
            self._team.agents[robot].kill()
            self._team.agents[robot].wait()
            self._later.append((soon, "rejoin", robot))
            self.counts["agents killed"] += 1
        else:
            self._team.agents[robot].send_signal(signal.SIGSTOP)
            self._later.append((time.monotonic() + self._random.uniform(*ASLEEP), "continue", robot))
            self.counts["agents suspended"] += 1

    def _undo(self, now: float) -> None:
        due = [entry for entry in self._later if entry[0] <= now]
        self._later = [entry for entry in self._later if entry[0] > now]
        for _, action, robot in due:
            if action == "resume":
                self._team.resume(str(PACE))
            elif action == "rejoin":
                self._team.rejoin(robot)
            else:
                (self._team.world if robot < 0 else self._team.agents[robot]).send_signal(signal.SIGCONT)

    def peace(self) -> None:
        """Wait for the end of the run."""
        while self._team.world.poll() is None:
            self._take_in()
            time.sleep(0.02)

    def _look(self) -> None:
        """Check that no process exits unless the test killed it."""
        self._take_in()
        away = self._away()
        for robot, process in {-1: self._team.world, **self._team.agents}.items():
            if robot not in away:
                name, code = "the world" if robot < 0 else f"agent-{robot}", process.poll()
                self._expect(code is None, f"{name} ended by itself with {code}")

    def _take_in(self) -> None:
        """Restart an agent that ended because a beacon was lost with the world's router and its sender."""
        for robot in self._team.agents.keys() - self._away():
            if self._team.agents[robot].poll() == 1 and self._was_bereft(robot):
                self._team.rejoin(robot)
                self.counts["agents that ended for a beacon that was lost with its sender"] += 1

    def _away(self) -> set[int]:
        return {robot for _, action, robot in self._later if action != "continue"}

    def _was_bereft(self, robot: int) -> bool:
        """True if an agent reports a beacon lost with the world's router while its sender had died too."""
        return "a beacon that decoded did not arrive" in self._said(f"agent-{robot}").rpartition("\n")[2]

    def _said(self, name: str) -> str:
        return (self._team.logs / f"{name}.log").read_text(errors="replace").rstrip()

    def _expect(self, holds: bool, otherwise: str) -> None:
        if not holds:
            said = self._said(otherwise.split(" ended")[0].removeprefix("the "))
            raise AssertionError(f"{otherwise}; until then {dict(self.counts)}; {said[-1000:]}")


def soak(out: Path, minutes: float, seed: int) -> dict[str, Any]:
    """Numbers of the soak if every criterion holds; raises AssertionError."""
    begun = time.monotonic()
    team = Team(out, minutes)
    try:
        (trouble := Trouble(team, seed)).rage(60.0 * minutes)
        team.world.send_signal(signal.SIGTERM)  # the rest at full speed
        assert team.world.wait(PATIENCE) in (0, -signal.SIGTERM)
        team.resume("max")
        trouble.peace()
        codes = {robot: process.wait(PATIENCE) for robot, process in {-1: team.world, **team.agents}.items()}
        assert set(codes.values()) == {0}, codes
        assert not team.orphans(), team.orphans()
    finally:
        team.end()
    summary = json.loads((out / "summary.json").read_text())
    loaded = log.load(out / NAME)
    changes = sum(bool(tick.attended) for tick in loaded.ticks())
    assert summary["ticks"] == loaded.scenario.ticks == sum(1 for _ in loaded.ticks())
    assert replay_command.rerun(loaded, all_robots=True)["digest"] == summary["digest"]
    assert summary["separation_error_rms"] < 0.5, summary["separation_error_rms"]
    assert summary["algebraic_connectivity"] > 0.0
    assert not (out / "checkpoint").exists()
    return {
        **trouble.counts,
        "ticks": summary["ticks"],
        "ticks at which robots came or went": changes,
        "processes": len(team.started),
        "separation error rms [m]": summary["separation_error_rms"],
        "wall [s]": time.monotonic() - begun,
    }


def main() -> None:
    """Print the numbers of the soak."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.soak", description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0, help="how long there are faults (default: 10)")
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(4)), help="of the faults")
    parser.add_argument("--out", type=Path, help="a new directory (default: a temporary one)")
    flags = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out = flags.out or Path(folder) / "run"
        print("seed", flags.seed, flush=True)
        for name, number in soak(out, flags.minutes, flags.seed).items():
            print(f"{name:>36}  {number:,.6g}")


if __name__ == "__main__":
    main()
