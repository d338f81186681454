"""The gate as a real process: the body stands after any end or freeze of the agent, within its bound of travel."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from console.backends.process_group import free_port
from fes.protocol.robot_control import HELD
from field.gate.launch import launch
from field.gate.link import TO_AGENT, FrameSocket, pair
from field.gate.rules.settings import Settings, Timing
from tests.support.gate_stage import Stage, settings, stage, until
from tests.support.paths import ROOT
from tests.support.processes import PATIENCE, alive

TIMING = Timing(lateness=0.5, pose_age=1.0, motion_check=None, permit=3.0)
"""Patient with the test's own processes, but not with old commands."""

SPEED = 0.2
PERIOD = TIMING.period


def run(main: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    asyncio.run(bounded())


def lateness(on: Stage, event: float) -> float:
    """Time by which the commands from `event` to the stand came later than their period, in all [s]."""
    times = [event, *(twist.time for twist in on.body.received if twist.time > event and twist.linear != 0.0)]
    ends = [*times[1:], next(twist.time for twist in on.body.received if twist.time > event and twist.linear == 0.0)]
    return sum(max(0.0, second - first - PERIOD) for first, second in zip(times, ends, strict=True))


async def check_travel(on: Stage, event: float, before: float) -> None:
    """Wait until the body stands, and hold its travel since the event against the bound."""
    await on.speed(lambda linear: linear == 0.0)
    travel = on.body.travelled - before
    limits = on.settings.limits
    bound = SPEED**2 / (2 * limits.acceleration) + SPEED * (TIMING.timeout + 2 * PERIOD)
    assert travel <= bound + SPEED * lateness(on, event)


@asynccontextmanager
async def agent(on: Stage) -> AsyncIterator[tuple["subprocess.Popen[str]", int]]:
    """A moving robot: the process of its agent, and the pid of its gate."""
    words = [sys.executable, "-m", "tests.support.gate_agent", str(SPEED)]
    running = subprocess.Popen(words, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    gate = 0
    try:
        assert running.stdin is not None
        assert running.stdout is not None
        running.stdin.write(on.settings.to_json() + "\n")
        running.stdin.flush()
        gate = int(await asyncio.to_thread(running.stdout.readline))
        while not await on.operator.has_started():
            await asyncio.sleep(0.01)
        await on.speed(lambda linear: linear >= SPEED)
        yield running, gate
    finally:
        for pid in (running.pid, gate):
            if pid and alive(pid):
                os.kill(pid, signal.SIGKILL)
        running.communicate()


def now() -> float:
    return asyncio.get_running_loop().time()


def test_a_killed_agent_ends_its_gate_and_the_body_stands_within_the_bound() -> None:
    async def main() -> None:
        async with stage(TIMING) as on, agent(on) as (running, gate):
            event, before = now(), on.body.travelled
            os.kill(running.pid, signal.SIGKILL)
            await check_travel(on, event, before)
            await until(lambda: not alive(gate))
            assert [twist[1:3] for twist in on.body.received[-5:]] == [(0.0, 0.0)] * 5

    run(main)


def test_a_frozen_agent_stops_the_body_and_its_stale_commands_never_move_it() -> None:
    async def main() -> None:
        async with stage(TIMING) as on, agent(on) as (running, _):
            event, before = now(), on.body.travelled
            os.kill(running.pid, signal.SIGSTOP)
            await check_travel(on, event, before)
            assert await on.reason(HELD) == "no command from the agent for 0.25 s"
            status = await on.operator.status()
            stood, frozen_for = on.body.travelled, 1.0
            await until(lambda: now() - event > frozen_for)  # 50 periods, whose commands the agent will send late
            assert on.body.travelled == stood
            os.kill(running.pid, signal.SIGCONT)
            await on.speed(lambda linear: linear >= SPEED)
            after = await on.operator.status()
            assert after.refused - status.refused >= 40  # all but those younger than 0.1 s

    run(main)


def test_a_frozen_gate_refuses_what_was_queued_meanwhile_and_then_resumes() -> None:
    async def main() -> None:
        async with stage(TIMING) as on, agent(on) as (_, gate):
            before, event = await on.operator.status(), now()
            os.kill(gate, signal.SIGSTOP)
            await until(lambda: now() - event > 2 * TIMING.lateness)
            count = len(on.body.received)
            os.kill(gate, signal.SIGCONT)
            await until(lambda: len(on.body.received) > count + 1)
            assert abs(on.body.received[count + 1].linear) < SPEED  # its loop was late: it commands zero first
            await on.speed(lambda linear: linear >= SPEED)
            assert (await on.operator.status()).refused > before.refused + 5

    run(main)


def test_a_gate_starts_without_unused_libraries() -> None:
    code = "import sys, field.gate.__main__; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "field.gate.process" in loaded
    assert not {"agents", "console", "mcap", "pydantic", "rich", "typer", "world"} & loaded


def test_a_told_end_slows_the_body_down_within_the_bound() -> None:
    async def main() -> None:
        async with stage(TIMING) as on, agent(on) as (running, gate):
            event, before = now(), on.body.travelled
            os.kill(gate, signal.SIGTERM)
            await check_travel(on, event, before)
            await until(lambda: not alive(gate) and running.poll() is not None)
            assert [twist[1:3] for twist in on.body.received[-5:]] == [(0.0, 0.0)] * 5
            assert running.stdout is not None
            assert running.stdout.read() == "ended\n"  # the agent sees it

    run(main)


def test_a_second_signal_ends_the_gate_at_once_and_with_zeros() -> None:
    async def main() -> None:
        async with stage(TIMING) as on, agent(on) as (_, gate):
            os.kill(gate, signal.SIGTERM)
            await on.speed(lambda linear: linear < SPEED)
            os.kill(gate, signal.SIGTERM)
            await until(lambda: not alive(gate))
            await on.speed(lambda linear: linear == 0.0)

    run(main)


def test_an_interrupt_of_the_terminal_does_not_end_the_gate() -> None:
    async def main() -> None:
        async with stage(TIMING) as on, agent(on) as (running, gate):
            assert os.getsid(gate) == gate != os.getsid(running.pid)
            os.kill(gate, signal.SIGINT)
            os.kill(gate, signal.SIGHUP)
            accepted = (await on.operator.status()).accepted
            while (await on.operator.status()).accepted < accepted + 10:
                await asyncio.sleep(0.01)
            assert on.body.linear == SPEED

    run(main)


def start_gate(text: str) -> "tuple[subprocess.Popen[str], FrameSocket]":
    own, far = pair()
    words = [sys.executable, "-m", "field.gate", "--link", str(far.fileno())]
    with far:
        child = subprocess.Popen(
            words, cwd=ROOT, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True, pass_fds=(far.fileno(),)
        )
    assert child.stdin is not None
    child.stdin.write(text + "\n")
    child.stdin.flush()
    return child, FrameSocket(own, TO_AGENT)


def test_a_body_on_another_machine_and_broken_settings_are_refused_in_one_line() -> None:
    table = json.loads(Settings(3).to_json())
    table["body"]["endpoint"] = "tcp/192.0.2.1:7447"
    for text, rule in ((json.dumps(table), "expects body.endpoint on this machine"), ("{", "one table of JSON")):
        child, end = start_gate(text)
        _, errors = child.communicate(timeout=PATIENCE)
        end.close()
        assert child.returncode == 1
        assert len(errors.splitlines()) == 1
        assert rule in errors


def test_a_gate_ends_with_its_agent_also_while_it_waits_for_its_endpoints() -> None:
    child, end = start_gate(settings(f"tcp/127.0.0.1:{free_port()}").to_json())
    end.close()
    _, errors = child.communicate(timeout=PATIENCE)
    assert child.returncode == 1
    assert errors.splitlines()[-1] == "fes-gate: error: the agent has ended before its gate was ready"


def test_no_folder_or_file_in_the_working_directory_takes_the_place_of_a_module_of_the_gate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "field").mkdir()
    for name in ("field/__init__.py", "random.py"):
        (tmp_path / name).write_text("raise ImportError('of another project')\n", encoding="utf-8")

    async def main() -> None:
        async with stage(TIMING) as on:
            monkeypatch.chdir(tmp_path)
            async with await launch(on.settings) as link:
                assert link.progress is not None

    run(main)
