"""The program fes-tabletop: it says when it is ready, writes the truth, and stops on request."""

import itertools
import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fes.protocol import sealed
from fes.system import strict_json
from tests.support.commands import vacant
from tests.support.mujoco import needs_mujoco
from tests.support.processes import command, start, until

MODULE = "world.tabletop.__main__"


def tabletop(*words: str) -> list[str]:
    return command(MODULE, *words)


@pytest.fixture(params=["kinematic", pytest.param("mujoco", marks=needs_mujoco)])
def table(request: Any, tmp_path: Path) -> Iterator[tuple["subprocess.Popen[str]", Path]]:
    """A table that writes its truth, and the folder of that file."""
    words = ["tabletop", "--body", request.param, "-l", vacant(), "--radio", "127.0.0.1:0", "--truth", "truth.jsonl"]
    running = start(tabletop(*words), tmp_path)
    yield running, tmp_path
    if running.poll() is None:
        running.kill()
    running.communicate()


def ready(running: "subprocess.Popen[str]") -> str:
    assert running.stderr is not None
    line = running.stderr.readline()
    assert " tabletop: ready: 10 robots (" in line
    return line


def lines(folder: Path) -> list[dict[str, Any]]:
    complete = (folder / "truth.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
    return [strict_json.loads(line) for line in complete if line.endswith("\n")]


def test_a_table_is_ready_in_one_line_writes_the_truth_and_stops_with_success(
    table: tuple["subprocess.Popen[str]", Path],
) -> None:
    running, folder = table
    ready(running)
    truth = until(lambda: len(lines(folder)) > 5 and lines(folder))
    assert [line["time"] for line in truth[:5]] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert truth[5]["poses"][6] == pytest.approx([225.0, 0.0, 1.05], abs=0.1)  # m: MuJoCo's robots settle
    assert all(after["monotonic"] > before["monotonic"] for before, after in itertools.pairwise(truth))
    running.send_signal(signal.SIGTERM)
    out, err = running.communicate()
    assert (running.returncode, out) == (0, "")
    assert "0 of 0 datagrams forwarded" in err
    assert "error" not in err


def test_the_truth_counts_the_datagrams_between_robots(table: tuple["subprocess.Popen[str]", Path]) -> None:
    running, folder = table
    port = int(ready(running).rpartition(":")[2])
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second,
    ):
        for number in range(20):
            for robot, its in ((0, first), (4, second)):  # 25 m apart: 0.5 % are lost
                its.sendto(sealed.seal(b"", "fes", robot, 1, number, b""), ("127.0.0.1", port))
        counts = until(lambda: [line for line in lines(folder) if line["sent"][4][0] == 20])
    assert counts[0]["sent"][0][4] in (19, 20)  # the first one came before robot 4 was known
    assert 15 <= counts[0]["forwarded"][4][0] <= 20
    assert sum(map(sum, counts[0]["sent"])) == counts[0]["sent"][0][4] + 20


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "SCENARIO"),
        (["nowhere.toml"], "No such file"),
        (["tabletop", "--body", "clay"], "--body"),
        (["tabletop", "--set", "tabletop.scal=1"], "tabletop.scale"),
        (["tabletop", "--radio", "0.0.0.0:7460"], "expects a loopback address and a port like 127.0.0.1:7460"),
        (["tabletop", "--radio", "127.0.0.1"], "expects a loopback address"),
        (["tabletop", "-l", "nonsense"], "not an endpoint like tcp/127.0.0.1:7447: nonsense"),
        (["tabletop", "-l", "VACANT", "--radio", "127.0.0.1:0", "--truth", "no/file"], "--truth: No such file"),
        (["tabletop", "--set", "channel.bursts.bad_share=.1", "--set", "channel.bursts.mean_length=1"], "bursts"),
    ],
)
def test_a_bad_argument_is_an_error_in_one_line(words: list[str], said: str, tmp_path: Path) -> None:
    given = [vacant() if word == "VACANT" else word for word in words]
    running = start(tabletop(*given), tmp_path)
    out, err = running.communicate()
    assert (running.returncode, out) == (1, "")
    [line] = err.splitlines()
    assert line.startswith("fes-tabletop: error: ")
    assert said in line
