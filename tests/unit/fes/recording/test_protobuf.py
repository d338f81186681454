"""Message types of a log: described in the file, in line with their source, and read within bounds."""

import re
from pathlib import Path
from typing import Any

import pytest
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from google.protobuf.unknown_fields import UnknownFieldSet
from mcap.reader import make_reader

from fes.recording import messages_pb2, protobuf
from tests.support import recordings
from tests.support.loop import load
from tests.support.paths import ROOT

SOURCE = ROOT / "fes/recording/messages.proto"

TYPES = {
    "uint64": FieldDescriptor.TYPE_UINT64,
    "bytes": FieldDescriptor.TYPE_BYTES,
    "double": FieldDescriptor.TYPE_DOUBLE,
    "sint64": FieldDescriptor.TYPE_SINT64,
    "Fix": FieldDescriptor.TYPE_MESSAGE,
}

READ = {
    "foxglove.FrameTransforms",
    "foxglove.SceneUpdate",
    "foxglove.Log",
    *(f"fes.{name}" for name in set(messages_pb2.DESCRIPTOR.message_types_by_name) - {"RobotStep", "Fix"}),
}
"""Types in the log of a run; the others are in the log of a robot."""


def message_class(name: str, described: bytes) -> Any:
    """The class of a message type that is known from a descriptor set alone."""
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(described).file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(name))


def test_the_generated_module_has_exactly_the_fields_of_its_source() -> None:
    source = re.sub(r"//.*", "", SOURCE.read_text(encoding="utf-8"))
    expected = {
        (name, field, int(number), TYPES[kind], label == "repeated", label == "optional")
        for name, body in re.findall(r"message (\w+) \{(.*?)\}", source, re.DOTALL)
        for label, kind, field, number in re.findall(r"(?:(repeated|optional) )?(\w+) (\w+) = (\d+);", body)
    }
    assert len(expected) == source.count(" = ") - 1  # beside the syntax
    assert messages_pb2.DESCRIPTOR.package == re.findall(r"package (\w+);", source)[0]
    generated = {
        (name, field.name, field.number, field.type, field.is_repeated, field.containing_oneof is not None)
        for name, described in messages_pb2.DESCRIPTOR.message_types_by_name.items()
        for field in described.fields
    }
    assert generated == expected


def test_every_message_of_a_log_is_read_to_its_last_byte_by_the_description_in_the_file(tmp_path: Path) -> None:
    recordings.record(tmp_path / "run.mcap", load("paper.toml", run__duration=1.0))
    classes: dict[str, Any] = {}
    with (tmp_path / "run.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if channel.message_encoding == "protobuf":
                kind = classes.setdefault(schema.name, message_class(schema.name, schema.data))
                content = kind.FromString(message.data)
                assert content.SerializeToString() == message.data
                assert len(UnknownFieldSet(content)) == 0
    assert classes.keys() == READ


def test_a_tick_of_zero_is_written_and_a_missing_tick_is_detected() -> None:
    # Hand-made: field 1 as a number, field 2 as bytes
    assert messages_pb2.Commands(tick=0, payloads=[b"a"]).SerializeToString() == bytes.fromhex("0800120161")
    assert not messages_pb2.Commands(payloads=[b"a"]).HasField("tick")


def test_a_payload_that_ends_too_soon_is_an_error() -> None:
    message = messages_pb2.Commands(tick=300, payloads=[b"abc"]).SerializeToString()
    assert message == bytes.fromhex("08ac021203616263")
    for size in (1, 2, 4, 6, len(message) - 1):
        with pytest.raises(ValueError, match=rf"^{size} bytes cannot be read as a message of type fes\.Commands$"):
            protobuf.parse(messages_pb2.Commands, message[:size])


def test_more_payloads_than_the_library_can_hold_in_little_memory_are_not_parsed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(protobuf, "MAX_PAYLOADS", 10)
    message = messages_pb2.Commands(tick=0, payloads=[b""] * 10).SerializeToString()
    assert len(protobuf.parse(messages_pb2.Commands, message).payloads) == 10
    # An empty payload; the same with a field number of two and of three bytes, which the library reads too
    for payload in (b"\x12\x00", b"\x92\x00\x00", b"\x92\x80\x00\x00"):
        assert len(messages_pb2.Commands.FromString(message + payload).payloads) == 11
        with pytest.raises(ValueError, match=r"^a message in which 11 bytes may begin a payload, more than 10$"):
            protobuf.parse(messages_pb2.Commands, message + payload)
