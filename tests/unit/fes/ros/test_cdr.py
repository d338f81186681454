"""XCDR1 by hand: alignment is counted after the encapsulation, and no bytes give another error than MessageError."""

import struct

import pytest

from fes.errors import MessageError
from fes.ros.cdr import LONGEST_TEXT, Reader, Writer

LITTLE, BIG = b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"


def test_a_double_after_a_text_starts_at_a_multiple_of_eight_after_the_encapsulation() -> None:
    writer = Writer("Test")
    writer.text("abc")  # 4 + 4 bytes: aligned already
    writer.doubles(1.0)
    writer.text("abcd")  # 16 + 4 + 5 = 25 bytes, so 7 of padding
    writer.doubles(2.0)
    body = b"\x04\0\0\0abc\0" + struct.pack("<d", 1.0) + b"\x05\0\0\0abcd\0" + bytes(7) + struct.pack("<d", 2.0)
    assert writer.payload() == LITTLE + body


def test_a_payload_is_padded_with_zeros_to_a_multiple_of_four() -> None:
    writer = Writer("Test")
    writer.text("")
    assert writer.payload() == LITTLE + b"\x01\0\0\0\0" + bytes(3)


@pytest.mark.parametrize(("head", "order"), [(LITTLE, "<"), (BIG, ">")])
def test_both_orders_of_bytes_are_read(head: bytes, order: str) -> None:
    reader = Reader("Test", head + struct.pack(f"{order}iI2d", -5, 2**32 - 1, 1.5, -0.1))
    assert (reader.int32(), reader.uint32(), reader.doubles(2)) == (-5, 2**32 - 1, (1.5, -0.1))
    reader.end()


@pytest.mark.parametrize("option", [b"\x00\x00", b"\x00\x03", b"\xff\xff"])
def test_the_options_of_the_encapsulation_are_not_looked_at(option: bytes) -> None:
    assert Reader("Test", b"\x00\x01" + option + struct.pack("<d", 1.0)).doubles(1) == (1.0,)


@pytest.mark.parametrize("head", [b"", b"\x00", b"\x00\x01\x00", b"\x00\x02\0\0", b"\x00\x07\0\0", b"\x01\x01\0\0"])
def test_another_encapsulation_is_refused(head: bytes) -> None:
    with pytest.raises(MessageError, match="Test: expects the encapsulation of XCDR1"):
        Reader("Test", head)


@pytest.mark.parametrize(
    ("raw", "rule"),
    [
        (struct.pack("<I", 0), "a text has 1 to 256 bytes"),
        (struct.pack("<I", LONGEST_TEXT + 2) + bytes(300), "a text has 1 to 256 bytes"),
        (struct.pack("<I", 2**32 - 1), "a text has 1 to 256 bytes"),
        (struct.pack("<I", 9) + b"short\0", "expects 17 bytes or more, got: 14"),
        (struct.pack("<I", 3) + b"abc", "ends with its only NUL"),
        (struct.pack("<I", 3) + b"a\0\0", "ends with its only NUL"),
        (struct.pack("<I", 3) + b"\xff\xfe\0", "printable UTF-8"),
        (struct.pack("<I", 3) + b"a\n\0", "printable UTF-8"),
    ],
)
def test_a_text_is_bounded_ends_with_its_only_nul_and_is_printable(raw: bytes, rule: str) -> None:
    with pytest.raises(MessageError, match=rule):
        Reader("Test", LITTLE + raw).text()


def test_the_longest_text_is_written_and_read_and_a_longer_one_is_refused() -> None:
    writer = Writer("Test")
    writer.text("ä" + "a" * (LONGEST_TEXT - 2))
    reader = Reader("Test", writer.payload())
    assert reader.text() == "ä" + "a" * (LONGEST_TEXT - 2)
    reader.end()
    with pytest.raises(MessageError, match="at most 255 bytes"):
        writer.text("ä" + "a" * (LONGEST_TEXT - 1))
    with pytest.raises(MessageError, match="no NUL"):
        writer.text("a\0b")


def test_after_the_values_only_padding_to_a_multiple_of_four_is_accepted() -> None:
    body = struct.pack("<I", 2) + b"a\0"
    for count in range(12):
        reader = Reader("Test", LITTLE + body + b"\xaa" * count)
        reader.text()
        if count in (0, 2):
            reader.end()
        else:
            with pytest.raises(MessageError, match="expects 10 bytes, got"):
                reader.end()


@pytest.mark.parametrize("value", [2**31, -(2**31) - 1])
def test_an_integer_beyond_32_bits_is_not_written(value: int) -> None:
    with pytest.raises(MessageError, match="32 bits"):
        Writer("Test").int32(value)
    with pytest.raises(MessageError, match="32 bits"):
        Writer("Test").uint32(-1)
    with pytest.raises(MessageError, match="32 bits"):
        Writer("Test").uint32(2**32)
