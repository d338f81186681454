"""The table of fes team status, for people and for programs."""

import io
import math

from rich.console import Console

from console.team import status
from console.team.status import State
from fes.errors import Unavailable
from fes.protocol.robot_control import HELD, RUNNING, STOPPED, GateStatus
from fes.protocol.robot_report import NO_AGE
from fes.system import strict_json
from tests.support.fake_robots import a_robot_report

STILL = (0.0, 0.0)
MOVING = GateStatus(0, RUNNING, "", (-123.4, 56.78, math.pi / 2), 0.04, (1.0, 0.1), 90, 1)
LAPSED = GateStatus(3, STOPPED, "the permit lapsed", (1.0, 2.0, -3.0), 12.5, STILL, 0, 0)
BLIND = GateStatus(12, HELD, "no pose yet", (0.0, 0.0, 0.0), NO_AGE, STILL, 0, 0)
STATES = [
    State(0, MOVING, True, a_robot_report(0, [1, 2])),
    State(3, LAPSED, False, None),
    State(12, BLIND, True, a_robot_report(12)),
    State(7, Unavailable("no process answers on fes/main/robot/7/status"), False, None),
]


def shown(width: int) -> list[str]:
    console = Console(width=width, file=io.StringIO())
    console.print(status.table(STATES), crop=False)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().split("\n")


def test_at_80_columns_each_state_is_whole() -> None:
    lines = shown(80)
    assert max(map(len, lines)) <= 80
    text = " ".join("\n".join(lines).split())
    assert "0 running alive -123.4 56.8 90° 0.04 s 2 68.0 m" in text
    assert "3 stopped absent 1.0 2.0 -172° 12.50 s – –" in text
    assert "12 held alive – – 0 – no pose yet" in text
    assert "7 absent absent – – – –" in text
    assert "…" not in text


def test_a_robot_whose_gate_is_absent_takes_one_line_in_a_wide_terminal() -> None:
    [line] = [line for line in shown(120) if line.startswith("7 ")]
    assert "its gate does not answer" in line


def test_the_tables_are_strict_json_in_which_unknown_is_null() -> None:
    tables = strict_json.loads(strict_json.dumps(status.tables(STATES)))
    assert [table["robot"] for table in tables] == [0, 3, 12, 7]
    assert [table["gate"] for table in tables] == ["running", "stopped", "held", None]
    assert [table["pose"] is None for table in tables] == [False, False, True, True]
    assert (tables[0]["links"], tables[0]["mean_estimate"], tables[1]["links"]) == ([1, 2], 68.0, None)
    assert tables[2]["mean_estimate"] is None
    assert tables[3]["reason"] == "its gate does not answer"
