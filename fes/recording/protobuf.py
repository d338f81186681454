"""Protocol Buffers through their library: message types described in a log, and messages read within bounds."""

from typing import TypeVar

from google.protobuf.descriptor import FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError, Message

MAX_PAYLOADS = 1 << 21
"""Most bytes in a message that may begin a payload, as a bound on memory: the library takes 30 bytes for an empty
payload of two bytes. By chance, such a byte occurs 1 << 19 times in the largest record."""

_PAYLOAD_TAGS = (b"\x12", b"\x92")
"""First byte of field 2 with a length; the second one if the number of the field takes more bytes than it needs."""

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
    if (tags := sum(map(data.count, _PAYLOAD_TAGS))) > MAX_PAYLOADS:
        raise ValueError(f"a message in which {tags:,} bytes may begin a payload, more than {MAX_PAYLOADS:,}")
    try:
        message: M = kind.FromString(data)
    except DecodeError:  # damage, or a lack of memory
        raise ValueError(f"{len(data):,} bytes cannot be read as a message of type {name}") from None
    return message
