"""Dropped messages: one line per kind, a bounded number of kinds per sender, and the totals at the end."""

import asyncio
import logging
import signal
import subprocess
from pathlib import Path

import pytest

from console.backends.process_group import free_port
from fes.errors import Rejected
from fes.protocol import keys
from fes.transport.drop_log import MAX_KINDS, DropLog
from tests.support import session
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command, until


def test_a_sender_that_invents_kinds_fills_neither_memory_nor_log(caplog: pytest.LogCaptureFixture) -> None:
    drops = DropLog(logging.getLogger("test"))
    for number in range(10 * MAX_KINDS):
        drops.reject(f"kind {number}", f"line {number}")
    assert len(drops.counts) == MAX_KINDS + 1
    assert drops.counts["other"] == 9 * MAX_KINDS
    assert len(caplog.messages) == MAX_KINDS + 1
    drops.reject("kind 3", "line 3")  # a kind that was known before
    assert drops.counts["kind 3"] == 2


def test_world_and_agent_log_their_totals_in_one_line_at_their_end(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = {
        "world": command("world.process", str(CONFIGS / "pair.toml"), "-l", endpoint),
        "agent": command("agents.process", "--id", "0", "-e", endpoint),
    }
    logs = {who: tmp_path / f"{who}.log" for who in words}
    running: list[subprocess.Popen[bytes]] = []

    def said(who: str, what: str) -> list[str]:
        return [line for line in logs[who].read_text().splitlines() if what in line]

    async def vandalize() -> None:
        async with session.client(endpoint) as vandal:
            for _ in range(3):
                vandal._session.put(keys.observation(keys.DEFAULT_RUN, 0), b"\xc1 junk")
                with pytest.raises(Rejected):  # the reply takes the same route as the puts before it
                    await vandal.get(keys.welcome(keys.DEFAULT_RUN, "1"), b"\xc1 junk", PATIENCE)

    try:
        for who, line in words.items():
            with logs[who].open("wb") as stream:
                running.append(subprocess.Popen(line, cwd=tmp_path, stdin=subprocess.DEVNULL, stderr=stream))
        until(lambda: said("agent", "ready"))
        asyncio.run(vandalize())
        until(lambda: said("agent", "Observation: is not msgpack"))
        running[0].send_signal(signal.SIGINT)
        assert [process.wait(PATIENCE) for process in running] == [0, 0]
    finally:
        for process in running:
            process.kill()
            process.wait()
    for who, kind in (("world", "Join: is not msgpack"), ("agent", "Observation: is not msgpack")):
        _, total = said(who, kind)  # the first of its kind, and their number
        assert total.endswith(" x3")
