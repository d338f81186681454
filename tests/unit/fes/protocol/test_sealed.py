"""The datagram of a beacon: only a holder of the key can make one, and any other bytes are refused."""

import hashlib
import hmac
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.errors import MessageError
from fes.protocol import sealed
from fes.protocol.sealed import LONGEST, LONGEST_PAYLOAD, MAX_BOOT, MAX_SEQUENCE, Sealed
from fes.protocol.wire import MAX_ID
from tests.support.examples import EXAMPLES

KEY, RUN = b"the team's key", "main"

robots, boots = st.integers(0, MAX_ID), st.integers(0, MAX_BOOT)
sequences, payloads = st.integers(0, MAX_SEQUENCE), st.binary(max_size=LONGEST_PAYLOAD)
messages = st.builds(Sealed, robots, boots, sequences, payloads)


def datagram(message: Sealed, key: bytes = KEY, run: str = RUN) -> bytes:
    return sealed.seal(key, run, *message)


def refusal(data: bytes, key: bytes = KEY, run: str = RUN) -> str:
    with pytest.raises(MessageError) as caught:
        sealed.opened(key, run, data)
    return caught.value.rule


@given(messages, st.binary(max_size=80), st.text(st.characters(exclude_categories=["Cs"])))
def test_a_sealed_payload_opens_with_the_same_key_in_the_same_run(message: Sealed, key: bytes, run: str) -> None:
    data = datagram(message, key, run)
    assert len(data) <= LONGEST < 1400
    assert sealed.opened(key, run, data) == message
    assert sealed.sender(data) == message.robot


def test_the_bytes_are_those_of_the_documented_layout() -> None:
    """The layout of the module's docstring, packed by hand, and the code computed in another way."""
    body = b"fesB\x01" + hashlib.sha256(b"main").digest()[:8] + struct.pack("<I", 7) + struct.pack("<Q", 2**63)
    body += struct.pack("<I", 9) + b"beacon"
    code = hmac.new(KEY, body, hashlib.sha256).digest()[:16]
    assert datagram(Sealed(7, 2**63, 9, b"beacon")) == body + code


@given(messages, st.data())
def test_a_datagram_with_any_bits_changed_is_refused(message: Sealed, data: st.DataObject) -> None:
    whole = bytearray(datagram(message))
    whole[data.draw(st.integers(0, len(whole) - 1))] ^= data.draw(st.integers(1, 255))
    assert refusal(bytes(whole)) in sealed.REFUSALS


@given(messages, st.integers(0, LONGEST))
def test_a_part_of_a_datagram_is_refused(message: Sealed, length: int) -> None:
    whole = datagram(message)
    assert refusal(whole[: min(length, len(whole) - 1)]) in sealed.REFUSALS


@settings(max_examples=2 * EXAMPLES)
@given(st.binary(max_size=1500) | st.binary(max_size=100).map(lambda tail: b"fesB\x01" + tail))
def test_any_other_bytes_are_refused_and_no_relay_fails_on_them(data: bytes) -> None:
    assert refusal(data) in sealed.REFUSALS
    robot = sealed.sender(data)
    assert robot is None or 0 <= robot <= MAX_ID


@given(messages)
def test_each_refusal_names_its_rule(message: Sealed) -> None:
    data = datagram(message)
    assert refusal(data, key=KEY + b"!") == sealed.FORGED
    assert refusal(data, key=b"") == sealed.FORGED
    assert refusal(data, run="other") == sealed.OTHER_RUN
    assert refusal(b"fesC" + data[4:]) == sealed.FOREIGN
    assert refusal(b"fesB\x02" + data[5:]) == sealed.WRONG_VERSION
    assert refusal(data + bytes(LONGEST + 1 - len(data))) == sealed.WRONG_LENGTH


def test_a_holder_of_the_key_cannot_name_a_robot_out_of_bounds() -> None:
    body = datagram(Sealed(0, 0, 0, b""))[:13] + struct.pack("<IQI", MAX_ID + 1, 0, 0)
    data = body + hmac.digest(KEY, body, "sha256")[:16]
    assert refusal(data) == sealed.WRONG_ROBOT
    assert sealed.sender(data) is None


@pytest.mark.parametrize(
    "message",
    [
        Sealed(-1, 0, 0, b""),
        Sealed(MAX_ID + 1, 0, 0, b""),
        Sealed(0, MAX_BOOT + 1, 0, b""),
        Sealed(0, 0, MAX_SEQUENCE + 1, b""),
        Sealed(0, 0, 0, bytes(LONGEST_PAYLOAD + 1)),
    ],
    ids=["negative robot", "robot", "boot", "sequence", "payload"],
)
def test_numbers_and_payloads_out_of_bounds_are_not_sealed(message: Sealed) -> None:
    with pytest.raises(MessageError, match="must"):
        datagram(message)
