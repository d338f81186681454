"""Logs for tests: recorded in one loop, read with the mcap library alone, and rewritten with a change."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap.writer import Writer

from console.backends import inprocess
from fes.recording.messages_pb2 import Commands
from fes.recording.writer.log_file import LogFile
from world.config.scenario import Scenario
from world.execution.recorder import Recorder

Edit = Callable[[str, int, bytes], bytes | None]
"""Topic, tick and payload of a message -> its new payload, or None to omit it."""


def record(path: Path, scenario: Scenario, name: str = "test") -> dict[str, Any]:
    """Record a run in one loop, without another process; returns its summary."""
    with Recorder(path, scenario, name, "inprocess", writer=LogFile) as recorder:
        summary = inprocess.run(scenario, name, recorder=recorder)
        recorder.conclude(summary)
    return summary


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    """Topic, tick and payload of every message, in the order of the file."""
    with path.open("rb") as file:
        messages = make_reader(file, validate_crcs=True).iter_messages(log_time_order=False)
        return [(channel.topic, message.sequence, message.data) for _, channel, message in messages]


def rewrite(path: Path, to: Path, edit: Edit, summary: dict[str, Any] | None = None, ended: bool = True) -> None:
    """Copy a log with edited messages, with another summary, or as if its run had been killed."""
    with path.open("rb") as file, to.open("wb") as out:
        reader, writer = make_reader(file), Writer(out, enable_data_crcs=True)
        writer.start("fes")
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            payload = edit(channel.topic, message.sequence, message.data)
            if channel.id not in channels:
                assert schema is not None
                registered = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, registered)
            if payload is not None:
                writer.add_message(
                    channels[channel.id], message.log_time, payload, message.log_time, message.sequence
                )
        for metadata in reader.iter_metadata() if ended else ():
            fields = metadata.metadata | ({"summary": json.dumps(summary)} if summary is not None else {})
            writer.add_metadata(metadata.name, fields)
        writer.finish()


def payloads(message: bytes) -> list[bytes]:
    """The payloads of all robots in a message of /observations, /beacons or /commands."""
    return list(Commands.FromString(message).payloads)


def edited(topic: str, tick: int, robot: int, change: Callable[[bytes], bytes]) -> Edit:
    """An edit of one robot's payload at one tick."""

    def edit(messages: str, at: int, message: bytes) -> bytes:
        if (messages, at) != (topic, tick):
            return message
        all_ = payloads(message)
        all_[robot] = change(all_[robot])
        return bytes(Commands(tick=tick, payloads=all_).SerializeToString())  # the three are encoded alike

    return edit
