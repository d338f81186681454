"""The encoding of logs, against the library protobuf and against Foxglove's own schemas."""

import importlib
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from fes.recording import protobuf, schemas
from fes.recording.descriptors import describe
from fes.recording.protobuf import Message
from tests.support import recordings
from tests.support.loop import load

READ = [
    *(schemas.FOXGLOVE[name] for name in ("FrameTransforms", "SceneUpdate", "Log")),
    *schemas.OWN.values(),
]


def library(module: str) -> Any:
    """A module of the library protobuf, or of Foxglove's schemas: witnesses, which nothing here needs to run."""
    return pytest.importorskip(module)


def message_class(name: str, described: bytes) -> Any:
    """What the library makes of a descriptor set."""
    pool = library("google.protobuf.descriptor_pool").DescriptorPool()
    for file in library("google.protobuf.descriptor_pb2").FileDescriptorSet.FromString(described).file:
        pool.Add(file)
    return library("google.protobuf.message_factory").GetMessageClass(pool.FindMessageTypeByName(name))


@pytest.mark.parametrize("kind", READ, ids=lambda kind: kind.name)
def test_the_library_understands_the_schemas(kind: Message) -> None:
    described = message_class(kind.name, describe(kind)).DESCRIPTOR
    expected = [(field.name, field.number) for field in kind.fields.values()]
    assert [(field.name, field.number) for field in described.fields] == expected
    assert [enum.name for enum in described.enum_types] == list(kind.enums)


@pytest.mark.parametrize("name", schemas.FOXGLOVE)
def test_fields_are_those_of_foxgloves_schemas(name: str) -> None:
    library("foxglove_schemas_protobuf")
    theirs = getattr(importlib.import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name).DESCRIPTOR
    kinds = {14: "enum", 11: "message", 1: "double", 8: "bool", 9: "string", 12: "bytes", 7: "fixed32"}
    expected = [(field.name, field.number, kinds[field.type]) for field in theirs.fields]
    ours = schemas.FOXGLOVE[name].fields.values()
    assert [(field.name, field.number, kind_of(field)) for field in ours] == expected
    enums = {enum.name: [(value.name, value.number) for value in enum.values] for enum in theirs.enum_types}
    assert schemas.FOXGLOVE[name].enums == enums


def kind_of(field: protobuf.Field) -> str:
    return "message" if field.message else "enum" if field.enum else field.kind


def test_the_library_reads_every_message_of_a_log_to_its_last_byte(tmp_path: Path) -> None:
    recordings.record(tmp_path / "run.mcap", load("paper.toml", run__duration=1.0))
    classes: dict[str, Any] = {}
    with (tmp_path / "run.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if channel.message_encoding == "protobuf":
                kind = classes.setdefault(schema.name, message_class(schema.name, schema.data))
                # Zeros are written here and left out there, so it is their second reading that must agree
                read = kind.FromString(message.data)
                assert kind.FromString(read.SerializeToString()) == read or "nan" in str(read)
                assert len(library("google.protobuf.unknown_fields").UnknownFieldSet(read)) == 0
    assert classes.keys() == {kind.name for kind in READ}


def test_a_payload_that_ends_too_soon_is_an_error() -> None:
    whole = schemas.OWN["Commands"].encode({"tick": 300, "payloads": [b"abc"]})
    assert list(protobuf.fields(whole)) == [(1, 300), (2, b"abc")]
    for size in (1, 2, 4, 6, len(whole) - 1):
        with pytest.raises(ValueError, match="goes on beyond the message"):
            list(protobuf.fields(whole[:size]))
