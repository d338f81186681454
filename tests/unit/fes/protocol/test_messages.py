"""Messages between processes: every message is decoded bit for bit, and bad bytes are one line, never a crash."""

import math

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.protocol import channel_change, wire
from fes.protocol.channel_change import ChangeResult
from tests.support.examples import EXAMPLES
from tests.support.payloads import CODECS, assert_refused_or_a_message, bits, refusal, values

NAMES = list(CODECS)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=2 * EXAMPLES)
@given(data=st.data())
def test_a_decoded_message_equals_the_encoded_one_bit_for_bit(name: str, data: st.DataObject) -> None:
    codec = CODECS[name]
    message = data.draw(codec.messages)
    assert bits(codec.decode(codec.encode(message))) == bits(message)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=2 * EXAMPLES)
@given(payload=st.binary(max_size=80) | values.map(msgpack.packb))
def test_a_payload_that_is_not_a_list_of_fields_is_rejected(name: str, payload: bytes) -> None:
    assert refusal(name, payload)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=2 * EXAMPLES)
@given(data=st.data())
def test_a_payload_with_arbitrary_fields_is_rejected_or_decodes_to_a_message(name: str, data: st.DataObject) -> None:
    codec = CODECS[name]
    fields = msgpack.unpackb(codec.encode(data.draw(codec.messages)))
    for position in data.draw(st.sets(st.integers(0, codec.fields), min_size=1, max_size=3)):
        fields[position] = data.draw(values)
    assert_refused_or_a_message(name, msgpack.packb(fields))


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=2 * EXAMPLES)
@given(data=st.data())
def test_a_damaged_payload_is_rejected_or_decodes_to_a_message(name: str, data: st.DataObject) -> None:
    codec = CODECS[name]
    payload = bytearray(codec.encode(data.draw(codec.messages)))
    begin = data.draw(st.integers(0, len(payload) - 1))
    payload[begin : begin + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
    assert_refused_or_a_message(name, bytes(payload))


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=20)
@given(data=st.data())
def test_a_payload_cut_short_is_rejected(name: str, data: st.DataObject) -> None:
    payload = CODECS[name].encode(data.draw(CODECS[name].messages))
    for end in range(len(payload)):
        assert refusal(name, payload[:end])


def test_equal_bytes_of_ids_share_one_read_only_array() -> None:
    payload = wire.id_bytes(np.array([2, 5, 9]))
    first, again = wire.ids("Beacon", payload), wire.ids("Beacon", bytes(bytearray(payload)))
    assert first is again
    assert first.tolist() == [2, 5, 9]
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 7


def test_the_result_of_a_change_may_have_no_optimum() -> None:
    payload = channel_change.encode_result(ChangeResult("channel.model", "trace", 3, math.nan))
    result = channel_change.decode_result(payload)
    assert math.isnan(result.optimal_separation)
    assert result._replace(optimal_separation=0.0) == ChangeResult("channel.model", "trace", 3, 0.0)
