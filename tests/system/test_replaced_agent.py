"""A suspended agent that wakes while another agent hosts its robot."""

import asyncio
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agents.process import Agent
from console.backends.process_group import free_port
from fes.errors import Overloaded, Rejected
from fes.protocol import messages
from fes.protocol.messages import Welcome
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command, start, until
from world.config.scenario import agent_config


class Hosted:
    """A world of two robots at the pace of the wall clock, and agents started by hand."""

    def __init__(self, where: Path) -> None:
        self.where, self.log = where, where / "world.log"
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.agents: list[subprocess.Popen[str]] = []
        words = [str(CONFIGS / "pair.toml"), "--duration", "1000", "--rtf", "1", "-l", self.endpoint]
        with self.log.open("wb") as stream:
            self.world = subprocess.Popen(command("world.process", *words), stderr=stream)

    def agent(self, robot: int) -> "subprocess.Popen[str]":
        words = command("agents.process", "--id", str(robot), "-e", self.endpoint)
        self.agents.append(start(words, self.where))
        return self.agents[-1]

    def says(self, what: str, times: int = 1) -> None:
        """Wait until the world has logged `what` often enough."""
        until(lambda: self.log.read_text().count(what) >= times)


@pytest.fixture
def hosted(tmp_path: Path) -> Iterator[Hosted]:
    going = Hosted(tmp_path)
    try:
        yield going
    finally:
        for agent in going.agents:
            agent.kill()
            agent.communicate()
        going.world.kill()
        going.world.wait()


def test_a_replaced_agent_that_wakes_ends_without_its_robot(
    hosted: Hosted,
) -> None:
    """Equal tokens count once: the death of the second agent would not be seen, and no agent could host its robot."""
    first = hosted.agent(0)
    hosted.agent(1)
    hosted.says("all robots are here")
    first.send_signal(signal.SIGSTOP)
    hosted.says("robot 0 is absent")
    second = hosted.agent(0)
    hosted.says("robot 0 is back")
    first.send_signal(signal.SIGCONT)
    _, complaint = first.communicate(timeout=PATIENCE)
    assert first.returncode == 1
    assert complaint.splitlines()[-1] == "fes-agent: error: robot 0 is hosted by another agent already"
    second.kill()
    hosted.says("robot 0 is absent", 2)
    assert "does not answer" not in hosted.log.read_text()  # its death was detected by its token, not by its silence
    hosted.agent(0)
    hosted.says("robot 0 is back", 2)


class Crowded:
    """A bus that is overloaded by queries for a while."""

    def __init__(self, answer: bytes = b"welcome") -> None:
        self.asked = 0
        self.answer = answer

    async def get(self, key: str, payload: bytes, timeout: float) -> bytes:
        self.asked += 1
        if self.asked < 3:
            raise Overloaded(key)
        return self.answer

    def declare_liveliness_subscriber(self, key: str, handler: Any) -> None: ...

    def declare_publisher(self, key: str, schema: str, mark: bytes | None = None) -> Any:
        return lambda payload: None

    def declare_queryable(self, key: str, handler: Any) -> None: ...


def test_an_agent_that_still_hosts_its_robot_survives_a_crowd_of_queries(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.runtime.membership.PATIENCE", 0.0)

    async def main() -> Crowded:
        crowded = Crowded()
        agent = Agent(crowded, "test", (0,))  # type: ignore[arg-type]
        for alive in (True, False, True):
            agent.membership.on_world("", alive)
        await agent.membership.confirmed()
        assert agent._inbox.wait(1, 0.0) is False  # it raises what has failed
        return crowded

    assert asyncio.run(main()).asked == 3


@pytest.mark.parametrize("another", [False, True])
def test_an_agent_does_not_join_another_run_in_place_of_its_own(another: bool) -> None:
    """A world that does not know its token yet treats it as new, and sends other settings."""
    welcomes = [
        messages.encode_welcome(Welcome((0,), agent_config(load("pair.toml", run__seed=seed)))) for seed in (1, 2)
    ]

    async def main() -> None:
        crowded = Crowded(welcomes[0])
        crowded.asked = 3
        agent = Agent(crowded, "test", (0,))  # type: ignore[arg-type]
        agent.membership.on_world("", True)
        await agent.join(1.0)
        agent.membership.on_world("", False)
        crowded.answer = welcomes[another]
        agent.membership.on_world("", True)
        await agent.membership.confirmed()
        if another:
            with pytest.raises(Rejected, match="another run has taken the place of this one"):
                agent._inbox.wait(1, 0.0)
        else:
            assert agent._inbox.wait(1, 0.0) is False

    asyncio.run(main())
