"""Protocol Buffers through their library: message types described in a log, and messages read within bounds."""

from typing import TypeVar

from google.protobuf.descriptor import FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError, Message

MAX_PAYLOADS = 1 << 21
"""Largest number of payloads in a message. It bounds memory: an empty payload takes two bytes in a message, and 30
bytes in the library. By chance, the byte that begins a payload occurs 1 << 18 times in the largest record."""

_PAYLOAD = b"\x12"  # field 2, with a length

M = TypeVar("M", bound=Message)


def describe(kind: type[Message]) -> bytes:
    """The binary FileDescriptorSet of a message type and of all types that it contains, for readers of the log."""
    files: dict[str, FileDescriptor] = {}

    def collect(file: FileDescriptor) -> None:
        for dependency in file.dependencies:
            collect(dependency)
        files.setdefault(file.name, file)

    collect(kind.DESCRIPTOR.file)
    described = FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(described.file.add())
    return bytes(described.SerializeToString())


def parse(kind: type[M], data: bytes) -> M:
    """The message of a type in `data`; raises ValueError.

    >>> from fes.recording.messages_pb2 import Commands
    >>> list(parse(Commands, bytes.fromhex("0801120161")).payloads)
    [b'a']
    """
    name = kind.DESCRIPTOR.full_name
    if (most := data.count(_PAYLOAD)) > MAX_PAYLOADS:
        raise ValueError(f"a message of {most:,} payloads, more than {MAX_PAYLOADS:,}")
    try:
        message: M = kind.FromString(data)
    except DecodeError:
        raise ValueError(f"{len(data):,} bytes that are not a message of type {name}") from None
    return message
