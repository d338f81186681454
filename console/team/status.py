"""fes team status: what the gates, the agents and the reports of the robots tell, as one table."""

import asyncio
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from rich import box
from rich.table import Table

from console.team import gates
from console.team.gates import Answer
from console.terminal.formatting import UNKNOWN, length
from console.terminal.printing import cell
from fes.errors import MessageError
from fes.protocol import keys
from fes.protocol.robot_control import HELD, RUNNING, GateStatus
from fes.protocol.robot_report import RobotReport, decode_robot_report
from fes.transport.bus import Bus

PATIENCE = 1.0
"""Longest wait for the reports of agents that are alive [s]."""

REASON = 12
"""Least width of the column of reasons."""

STYLES = {RUNNING: "green", HELD: "yellow"}


class State(NamedTuple):
    """One robot as it was asked."""

    robot: int
    gate: Answer
    is_agent_alive: bool
    report: RobotReport | None
    """Its report, if one arrived meanwhile."""


async def collect(bus: Bus, run: str, robots: Sequence[int]) -> list[State]:
    """The state of each robot: its gate is asked, and the next report of an agent that is alive is awaited."""
    payloads: dict[int, bytes] = {}
    arrived, loop = asyncio.Event(), asyncio.get_running_loop()

    def on_report(key: str, payload: bytes | None) -> None:
        robot = keys.robot_of(key)
        if robot in robots and payload is not None and len(payload) > 0:
            payloads[robot] = payload  # type: ignore[index]
            loop.call_soon_threadsafe(arrived.set)

    unsubscribe = bus.declare_subscriber(keys.robot_report(run, "*"), on_report)
    tokens = await bus.liveliness_get(keys.robot_alive(run, "*"), PATIENCE)
    alive = {keys.robot_of(key) for key in tokens}
    answers = await gates.ask(bus, keys.gate_status, run, robots)
    try:
        async with asyncio.timeout(PATIENCE):
            while not alive.intersection(robots) <= payloads.keys():
                arrived.clear()
                await arrived.wait()
    except TimeoutError:
        pass  # a robot that does not report is shown without its report
    unsubscribe()
    return [State(robot, answers[robot], robot in alive, _decoded(robot, payloads.get(robot))) for robot in robots]


def _decoded(robot: int, payload: bytes | None) -> RobotReport | None:
    try:
        report = decode_robot_report(payload) if payload is not None else None
    except MessageError:
        return None
    return report if report is not None and report.robot == robot else None


def table(states: Sequence[State]) -> Table:
    """The states, for a terminal of 80 columns or more; the pose is x, y and heading."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1), collapse_padding=True)
    for name in ("robot", "gate", "agent"):
        rows.add_column(name, no_wrap=True)
    for name in ("pose [m]", "age", "links", "estimate"):
        rows.add_column(name, no_wrap=True, justify="right")
    rows.add_column("reason", overflow="fold", min_width=REASON)
    for state in states:
        rows.add_row(cell(state.robot), *_cells(state))
    return rows


def _cells(state: State) -> list[Any]:
    agent = cell("alive") if state.is_agent_alive else cell("absent", "bold red")
    report = [UNKNOWN, UNKNOWN] if state.report is None else [str(_links(state.report)), _estimate(state.report)]
    if not isinstance(state.gate, GateStatus):
        return [cell("absent", "bold red"), agent, UNKNOWN, UNKNOWN, *report, cell(gates.words(state.gate))]
    mode = cell(state.gate.mode, STYLES.get(state.gate.mode, "bold red"))
    pose = [UNKNOWN, UNKNOWN]
    if state.gate.pose_age >= 0.0:
        x, y, heading = state.gate.pose
        degrees = f"{math.degrees(math.remainder(heading, math.tau)):.0f}°"
        pose = [f"{x:.1f} {y:.1f} {degrees}", f"{state.gate.pose_age:.2f} s"]
    return [mode, agent, *pose, *report, cell(state.gate.reason)]


def tables(states: Sequence[State]) -> list[dict[str, Any]]:
    """The states, for JSON; None stands for what is unknown."""
    return [_table(state) for state in states]


def _table(state: State) -> dict[str, Any]:
    gate, report = state.gate, state.report
    known = gate if isinstance(gate, GateStatus) else None
    has_pose = known is not None and known.pose_age >= 0.0
    return {
        "robot": state.robot,
        "gate": known.mode if known else None,
        "reason": known.reason if known else gates.words(gate),
        "pose": list(known.pose) if known and has_pose else None,
        "pose_age": known.pose_age if known and has_pose else None,
        "twist": list(known.twist) if known else None,
        "accepted": known.accepted if known else None,
        "refused": known.refused if known else None,
        "agent_alive": state.is_agent_alive,
        "links": report.command.links.tolist() if report else None,
        "mean_estimate": _mean(report) if report else None,
        "elapsed": report.elapsed if report else None,
    }


def _links(report: RobotReport) -> int:
    return len(report.command.links)


def _mean(report: RobotReport) -> float:
    estimates = report.command.estimates
    return float(estimates.mean()) if len(estimates) else math.nan


def _estimate(report: RobotReport) -> str:
    return length(_mean(report))
