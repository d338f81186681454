"""Changes of a run, in its log: replayed to the same digest, and compared."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import compare, log
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ParameterChange
from tests.support import recordings, session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from world.execution.recorder import Recorder
from world.server.server import Server


def test_changes_by_fes_set_are_replayed(tmp_path: Path) -> None:
    pair = load("pair.toml", run__duration=4.0)

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with session.client(endpoint) as person:
            begin.set()
            objective = channel_change.encode_change(ParameterChange("channel.reference_snr", 2e6))
            await person.get(keys.change(session.RUN), objective, PATIENCE)

    async def run() -> tuple[dict[str, Any], Server]:
        with Recorder(tmp_path / "run.mcap", pair, "test", "processes") as recorder:
            summary, server, _ = await session.run(pair, [[0], [1]], disturb, recorder)
            recorder.conclude(summary)
            assert server.run.scenario.event
        return summary, server

    summary, server = asyncio.run(asyncio.wait_for(run(), PATIENCE))
    loaded = log.load(tmp_path / "run.mcap")
    [changes] = [tick.changes for tick in loaded.ticks() if tick.changes]
    assert changes == [("channel.reference_snr", 2e6)]
    assert loaded.scenario == pair
    assert summary["digest"] != inprocess.run(pair, "test")["digest"]
    assert replay_command.rerun(loaded, all_robots=True) == json.loads(json.dumps(summary))

    recordings.record(tmp_path / "again.mcap", server.run.scenario, "scenario")  # as scenario.toml holds it then
    again = log.load(tmp_path / "again.mcap")
    assert list(compare.of_scenarios(loaded, again)) == []
    assert compare.first_difference(loaded, again) is None
    recordings.record(tmp_path / "before.mcap", pair)
    [(path, mine, theirs)] = compare.of_scenarios(loaded, log.load(tmp_path / "before.mcap"))
    assert (path, theirs) == ("event", [])
    assert mine[0]["set"] == {"channel.reference_snr": 2e6}


@pytest.mark.parametrize(
    "act",
    [
        {"kill": [1]},
        {"hang": [1]},
        {"transmitter": {"robot": 1, "delay": 0.4}},
        {"clock": {"robot": 1, "skew": 0.1}},
        {"world_away": 1.0},
    ],
    ids=lambda act: next(iter(act)),
)
def test_compare_names_every_kind_of_event_in_which_scenarios_differ(act: dict[str, Any], tmp_path: Path) -> None:
    for name, events in (("with", [{"at": 0.5, **act}]), ("without", [])):
        recordings.record(tmp_path / f"{name}.mcap", load("pair.toml", run__duration=0.2, event=events))
    with_event, without = log.load(tmp_path / "with.mcap"), log.load(tmp_path / "without.mcap")
    [(path, events, none)] = compare.of_scenarios(with_event, without)
    assert (path, none) == ("event", [])
    assert [event.keys() for event in events] == [{"at", *act}]
