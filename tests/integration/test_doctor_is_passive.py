"""The doctor asks the world of a run once, and publishes on no key."""

import asyncio
from collections import Counter

import pytest

from console.doctor import network
from fes.protocol import keys
from fes.transport.bus import Query
from fes.transport.endpoints import Endpoints
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN
from world.execution.run import Run
from world.server.server import Server


def test_the_doctor_queries_only_the_world_and_only_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network, "PATIENCE", PATIENCE)
    asked, said = Counter[str](), list[str]()
    answer, refuse = Query.reply, Query.reply_err

    def answered(query: Query, payload: bytes, schema: str) -> None:
        asked[query.key] += 1
        answer(query, payload, schema)

    def refused(query: Query, why: str) -> None:
        asked[query.key] += 1
        refuse(query, why)

    monkeypatch.setattr(Query, "reply", answered)
    monkeypatch.setattr(Query, "reply_err", refused)

    async def main() -> None:
        async with session.router() as (opened, endpoint), asyncio.timeout(PATIENCE):
            Server(opened, Run(load("pair.toml")), "test", RUN)
            async with session.client(endpoint) as watcher:
                watcher.declare_subscriber("**", lambda key, payload: said.append(key))
                _, robots = await network.examine(Endpoints("client", (endpoint,)), RUN, True)
                assert robots == 2
                await watcher.get(keys.about(RUN), b"", PATIENCE)  # all publications arrived before this reply

    asyncio.run(main())
    assert asked == {keys.about(RUN): 2}  # the other query is the test's own
    assert not said
