"""Two worlds on one run: at most one starts, in any order of their looks."""

import asyncio
import contextlib
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from bench.size.own_router import SOURCE
from console.backends.process_group import free_port
from fes.errors import Rejected, Unavailable
from fes.protocol import keys
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command, start
from tests.support.session import client, router
from world.server import claim

RUN = "test"
REFUSAL = "another world of run 'test' is running or starting (--run gives this one another name)"


def test_a_second_world_on_the_same_network_refuses_to_start_with_one_line(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    pair = str(CONFIGS / "pair.toml")
    first = start(command("world.process", pair, "-l", endpoint), tmp_path)
    assert first.stderr is not None
    assert "waiting for 2 robots" in first.stderr.readline()
    other = f"tcp/127.0.0.1:{free_port()}"
    for words in (["-m", "client", "-e", endpoint], ["-e", endpoint, "-l", other]):
        second = start(command("world.process", pair, *words), tmp_path)
        _, err = second.communicate(timeout=PATIENCE)
        assert (second.returncode, err) == (1, f"fes-world: error: {REFUSAL.replace('test', 'main')}\n")
    assert first.poll() is None  # the first one still waits
    third = start(command("world.process", pair, "-m", "client", "-e", endpoint, "--run", "other"), tmp_path)
    assert third.stderr is not None
    assert "waiting for 2 robots" in third.stderr.readline()
    for process in (third, first):
        process.terminate()
        process.communicate(timeout=PATIENCE)


def test_at_most_one_of_several_simultaneous_worlds_starts() -> None:
    async def attempt(endpoint: str, round_: int, after: float, decided: asyncio.Barrier) -> bool:
        async with client(endpoint) as opened:
            await asyncio.sleep(after)
            try:
                await claim.claim_run(opened, f"{RUN}{round_}", connected=False)
                started = True
            except Rejected:
                started = False
            await decided.wait()  # it stays, so that a later world sees it
            return started

    async def main() -> list[list[bool]]:
        outcomes = []
        async with router() as (_, endpoint):
            for round_ in range(12):  # 0 to 2 ms apart
                decided = asyncio.Barrier(3)
                attempts = [attempt(endpoint, round_, 2e-4 * round_ * number, decided) for number in range(3)]
                outcomes.append(list(await asyncio.gather(*attempts)))
        return outcomes

    assert max(map(sum, asyncio.run(main()))) <= 1


def test_the_first_of_successive_worlds_starts() -> None:
    async def main() -> list[bool]:
        async with router() as (_, endpoint), contextlib.AsyncExitStack() as worlds:
            started = []
            for _ in range(3):
                opened = await worlds.enter_async_context(client(endpoint))
                try:
                    await claim.claim_run(opened, RUN, connected=False)
                    started.append(True)
                except Rejected:
                    started.append(False)
            return started

    assert asyncio.run(main()) == [True, False, False]


def test_at_most_one_of_two_worlds_with_connected_routers_starts() -> None:
    async def main() -> list[int]:
        started = []
        for _ in range(3):
            ends = [f"tcp/127.0.0.1:{free_port()}" for _ in range(2)]
            async with (
                bus.opened(Endpoints("router", (), (ends[0],))) as first,
                bus.opened(Endpoints("router", (ends[0],), (ends[1],))) as second,
            ):
                claims = [claim.claim_run(opened, RUN, connected=True) for opened in (first, second)]
                outcomes = await asyncio.gather(*claims, return_exceptions=True)
                assert all(outcome is None or isinstance(outcome, Rejected) for outcome in outcomes)
                started.append(sum(outcome is None for outcome in outcomes))
        return started

    assert max(asyncio.run(main())) <= 1


def test_a_world_that_has_ended_holds_no_claim() -> None:
    async def main() -> None:
        async with router() as (_, endpoint):
            for _ in range(3):
                async with client(endpoint) as opened:
                    await claim.claim_run(opened, RUN, connected=False)
                async with client(endpoint) as watcher:
                    async with asyncio.timeout(PATIENCE):
                        while await watcher.liveliness_get(keys.world_tokens(RUN), 1.0):
                            await asyncio.sleep(0.01)

    asyncio.run(main())


def test_a_world_without_a_claim_is_detected_by_its_token() -> None:
    async def main() -> None:
        async with router() as (world, endpoint), client(endpoint) as newcomer:
            world.declare_token(keys.world_alive(RUN))
            with pytest.raises(Rejected, match=re.escape(REFUSAL)):
                await claim.claim_run(newcomer, RUN, connected=True)

    asyncio.run(main())


def test_a_world_that_cannot_look_for_other_worlds_does_not_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """It sees only its own claim, which does not prove that it is alone."""
    monkeypatch.setattr(claim, "TIMEOUT", 0.5)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    between = subprocess.Popen([sys.executable, "-c", SOURCE, endpoint], stdin=subprocess.PIPE)

    async def main() -> None:
        async with client(endpoint) as first, client(endpoint) as second:
            await claim.claim_run(first, RUN, connected=False)
            between.send_signal(signal.SIGSTOP)
            os.waitpid(between.pid, os.WUNTRACED)  # until then it may still answer
            try:
                with pytest.raises(
                    Unavailable, match=r"^the router does not say within 0.5 s who is alive on fes/test/"
                ):
                    await claim.claim_run(second, RUN, connected=False)
            finally:
                between.send_signal(signal.SIGCONT)

    try:
        asyncio.run(main())
    finally:
        between.kill()
        between.communicate()
