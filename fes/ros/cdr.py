"""Numbers and texts in XCDR1, the encoding of ROS 2 messages (OMG DDS-XTypes 1.3, section 7.4).

Four bytes of encapsulation come first: 0, the order of bytes (0 big, 1 little endian), and two of options. Each
number is aligned to its own size, counted after these four. Real writers leave arbitrary bytes in the padding, so a
reader never looks at them, and two payloads of equal values may differ.
"""

import struct

from fes.errors import MessageError

HEADER = 4
"""Length of the encapsulation [bytes]."""

LONGEST_TEXT = 255
"""Longest text that is read or written [bytes], without the NUL at its end."""

UNIT = 4
"""A payload may be padded to a multiple of this [bytes]."""

_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}


class Reader:
    """The values of a payload, one after the other; each method raises MessageError beyond the end."""

    def __init__(self, schema: str, payload: bytes) -> None:
        self._schema = schema
        self._payload = payload
        self._next = HEADER
        order = _ORDERS.get(payload[:2]) if len(payload) >= HEADER else None
        if order is None:
            raise self.error("expects the encapsulation of XCDR1, 0000 or 0001", payload[:HEADER].hex() or "nothing")
        self._order = order

    def error(self, rule: str, value: object = "") -> MessageError:
        """An error about this payload."""
        return MessageError(self._schema, rule, str(value))

    def int32(self) -> int:
        """A signed integer."""
        return int(self._numbers("i", 1)[0])

    def uint32(self) -> int:
        """An unsigned integer."""
        return int(self._numbers("I", 1)[0])

    def doubles(self, count: int) -> tuple[float, ...]:
        """So many floats of 64 bits; they need not be finite."""
        return self._numbers("d", count)

    def skip_doubles(self, count: int) -> None:
        """Pass over so many floats of 64 bits, which must be there."""
        self._advance(8, 8 * count)

    def text(self) -> str:
        """A printable text in UTF-8 of at most LONGEST_TEXT bytes."""
        length = self.uint32()
        if not 1 <= length <= LONGEST_TEXT + 1:
            raise self.error(f"a text has 1 to {LONGEST_TEXT + 1} bytes with its NUL, got", length)
        start = self._advance(1, length)
        raw = self._payload[start : self._next]
        if raw.find(0) != length - 1:
            raise self.error("a text ends with its only NUL, got", raw[:20].hex())
        try:
            text = raw[:-1].decode()
        except UnicodeDecodeError:
            text = "\n"  # refused below
        if not text.isprintable():
            raise self.error("a text is printable UTF-8, got", raw[:20].hex())
        return text

    def end(self) -> None:
        """Raise MessageError unless only padding to a multiple of UNIT is left."""
        padded = HEADER + _aligned(self._next - HEADER, UNIT)
        if len(self._payload) not in (self._next, padded):
            raise self.error(f"expects {self._next} bytes, got", len(self._payload))

    def _numbers(self, code: str, count: int) -> tuple[float, ...]:
        size = struct.calcsize(f"={code}")
        start = self._advance(size, count * size)
        return struct.unpack_from(f"{self._order}{count}{code}", self._payload, start)

    def _advance(self, alignment: int, length: int) -> int:
        start = HEADER + _aligned(self._next - HEADER, alignment)
        if start + length > len(self._payload):
            raise self.error(f"expects {start + length} bytes or more, got", len(self._payload))
        self._next = start + length
        return start


class Writer:
    """A payload in little endian; its padding is zeros."""

    def __init__(self, schema: str) -> None:
        self._schema = schema
        self._body = bytearray()

    def error(self, rule: str, value: object = "") -> MessageError:
        """An error about this payload."""
        return MessageError(self._schema, rule, str(value))

    def int32(self, value: int) -> None:
        """Add a signed integer; raises MessageError beyond 32 bits."""
        if not -(2**31) <= value < 2**31:
            raise self.error("expects an integer of 32 bits, got", value)
        self._add("i", 4, value)

    def uint32(self, value: int) -> None:
        """Add an unsigned integer; raises MessageError beyond 32 bits."""
        if not 0 <= value < 2**32:
            raise self.error("expects an unsigned integer of 32 bits, got", value)
        self._add("I", 4, value)

    def doubles(self, *values: float) -> None:
        """Add floats of 64 bits."""
        self._add(f"{len(values)}d", 8, *values)

    def text(self, value: str) -> None:
        """Add a text; raises MessageError if it is longer than LONGEST_TEXT bytes or holds a NUL."""
        raw = value.encode(errors="replace")
        if len(raw) > LONGEST_TEXT or 0 in raw:
            raise self.error(f"a text has at most {LONGEST_TEXT} bytes and no NUL, got", repr(value[:40]))
        self.uint32(len(raw) + 1)
        self._body += raw + b"\0"

    def payload(self) -> bytes:
        """All that was added, after the encapsulation, padded to a multiple of UNIT."""
        return b"\x00\x01\x00\x00" + self._body.ljust(_aligned(len(self._body), UNIT), b"\0")

    def _add(self, code: str, alignment: int, *values: float) -> None:
        padded = self._body.ljust(_aligned(len(self._body), alignment), b"\0")
        self._body = padded + struct.pack(f"<{code}", *values)


def _aligned(offset: int, alignment: int) -> int:
    return offset + -offset % alignment
