"""Protocol Buffers, as much as a log needs: message types in their own notation, encoded and read.

It is the encoding that every viewer of a log reads without being told how; of Foxglove's schemas Rerun reads no
other. A value of a message is a mapping from its fields to values, what is left out is not encoded; of a message that
has only numbers it is a tuple of them all; and what is encoded already is bytes. A value of an enumeration is its
number; integers are not negative.
"""

import re
import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from fes.arrays.types import Floats

SCALARS = {
    "double": 1,
    "int64": 3,
    "uint64": 4,
    "int32": 5,
    "fixed32": 7,
    "bool": 8,
    "string": 9,
    "bytes": 12,
    "uint32": 13,
}
"""Type -> its number in a descriptor."""

_VARINT, _FIXED64, _LENGTH, _FIXED32 = 0, 1, 2, 5

_ENUMS = re.compile(r"enum (\w+) \{([^{}]*)\}")
_MESSAGES = re.compile(r"message (\w+) \{((?:[^{}]|\{[^{}]*\})*)\}")
_FIELDS = re.compile(r"(repeated )?([\w.]+) (\w+) = (\d+);")
_VALUES = re.compile(r"(\w+) = (\d+);")

Types = dict[str, "Message"]
Enums = dict[str, list[tuple[str, int]]]
"""Names and numbers of each enumeration of a message type."""


class Field:
    """One field of a message type."""

    def __init__(self, name: str, kind: str, number: int, repeated: bool, types: Types, enum: bool) -> None:
        self.name, self.kind, self.number, self.repeated, self.enum = name, kind, number, repeated, enum
        self._types = types
        wire = {"double": _FIXED64, "fixed32": _FIXED32, "string": _LENGTH, "bytes": _LENGTH}
        self.tag = varint(number << 3 | (wire.get(kind, _VARINT) if kind in SCALARS or enum else _LENGTH))
        self._one = self._encoder()

    @property
    def message(self) -> "Message | None":
        """The type of its value, if that is a message."""
        return self._types.get(self.kind)

    def encode(self, value: Any) -> bytes:
        """The field with this value, or with each of a list of values."""
        if self.repeated:
            return b"".join([self.tag + self._one(item) for item in value])
        return self.tag + self._one(value)

    def _encoder(self) -> Callable[[Any], bytes]:
        if self.kind == "double":
            return struct.Struct("<d").pack
        if self.kind == "fixed32":
            return struct.Struct("<I").pack
        if self.kind == "string":
            return lambda text: _counted(text.encode())
        if self.kind == "bytes":
            return _counted
        if self.kind in SCALARS or self.enum:
            return varint
        return lambda value: _counted(self._types[self.kind].encode(value))


class Message:
    """A message type."""

    def __init__(self, name: str, fields: list[Field], enums: Enums) -> None:
        self.name = name
        """With its package."""
        self.enums = enums
        self.fields = {field.name: field for field in fields}
        self._flat: struct.Struct | None = None
        self._tags: list[int] = []
        if fields and all(field.kind == "double" and not field.repeated and field.number < 16 for field in fields):
            self._flat = struct.Struct("<" + "Bd" * len(fields))
            self._tags = [field.tag[0] for field in fields]

    def encode(self, value: Mapping[str, Any] | tuple[float, ...] | bytes) -> bytes:
        """The bytes of a value."""
        if isinstance(value, bytes):
            return value
        if isinstance(value, tuple):
            assert self._flat is not None, f"{self.name} has fields that are not numbers"
            return self._flat.pack(*[part for pair in zip(self._tags, value, strict=True) for part in pair])
        fields = self.fields
        return b"".join([fields[name].encode(one) for name, one in value.items()])

    def encode_rows(self, rows: Floats) -> list[bytes]:
        """The bytes of many values of a message that has only numbers, one a row [k, fields]."""
        found = np.empty((*rows.shape, 9), dtype=np.uint8)
        found[..., 0] = self._tags
        found[..., 1:] = rows.astype("<f8", order="C").view(np.uint8).reshape(*rows.shape, 8)
        whole, size = found.tobytes(), 9 * rows.shape[1]
        return [whole[at : at + size] for at in range(0, len(whole), size)]


def parse(package: str, text: str, known: Types | None = None) -> Types:
    """The message types of a package, by their names without it, written as in a .proto file.

    >>> types = parse("demo", "message Point { double x = 1; double y = 2; } message Path { repeated Point at = 1; }")
    >>> types["Path"].encode({"at": [(1.0, 2.0)]}).hex()
    '0a1209000000000000f03f110000000000000040'
    """
    types = dict(known or {})
    found: Types = {}
    for name, body in _MESSAGES.findall(re.sub(r"//.*", "", text)):
        enums = {
            enum: [(one, int(number)) for one, number in _VALUES.findall(values)]
            for enum, values in _ENUMS.findall(body)
        }
        fields = [
            Field(field, kind, int(number), bool(repeated), types, kind in enums)
            for repeated, kind, field, number in _FIELDS.findall(_ENUMS.sub("", body))
        ]
        found[name] = types[name] = Message(f"{package}.{name}" if package else name, fields, enums)
    return found


def varint(value: int) -> bytes:
    """A number from 0 in seven bits a byte.

    >>> varint(300).hex()
    'ac02'
    """
    if value < 0x80:
        return value.to_bytes(1, "little")
    found = bytearray()
    while value >= 0x80:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)


def fields(payload: bytes) -> Iterator[tuple[int, int | bytes]]:
    """Number and raw value of each field in a payload: an integer, or bytes; raises ValueError.

    >>> list(fields(bytes.fromhex("0801120161")))
    [(1, 1), (2, b'a')]
    """
    at = 0
    while at < len(payload):
        tag, at = _varint_at(payload, at)
        wire = tag & 7
        if wire == _VARINT:
            number, at = _varint_at(payload, at)
            yield tag >> 3, number
            continue
        size = {_FIXED64: 8, _FIXED32: 4}.get(wire)
        if wire == _LENGTH:
            size, at = _varint_at(payload, at)
        if size is None or at + size > len(payload):
            raise ValueError("a field that goes on beyond the message")
        yield tag >> 3, payload[at : at + size]
        at += size


def _varint_at(payload: bytes, at: int) -> tuple[int, int]:
    """A number, and where it ends."""
    value = shift = 0
    while at < len(payload):
        byte = payload[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at
    raise ValueError("a number that goes on beyond the message")


def _counted(content: bytes) -> bytes:
    return varint(len(content)) + content
