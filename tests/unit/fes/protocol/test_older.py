"""Payloads of protocol 3 are those of this protocol, to the byte, with the tick of the fix."""

import msgpack
import pytest
from hypothesis import given

from fes.protocol import messages, older, wire
from tests.support.payloads import CODECS


def downgraded(payload: bytes, dropped: int = 0) -> bytes:
    """A payload as protocol 3 had it."""
    fields = msgpack.unpackb(payload)
    return bytes(msgpack.packb([3, *fields[1 : len(fields) - dropped]]))


@given(CODECS["Observation"].messages)
def test_an_observation_gets_its_own_tick_as_that_of_its_fix(message: messages.Observation) -> None:
    payload = messages.encode_observation(message._replace(fixed=None))
    assert older.renewed_observation(downgraded(payload, dropped=1), message.tick) == payload


@pytest.mark.parametrize("name", ["Beacon", "Command", "Report"])
def test_other_messages_get_the_number_of_this_protocol(name: str) -> None:
    @given(CODECS[name].messages)
    def check(message: object) -> None:
        payload = CODECS[name].encode(message)
        assert older.renewed(downgraded(payload)) == payload

    check()


@pytest.mark.parametrize("payload", [b"", b"\x9a", b"\x9a\x02\x07", b"\x93\xc0", wire.pack(1, 2)])
def test_any_other_bytes_are_left_as_they_are_and_rejected_later(payload: bytes) -> None:
    assert older.renewed(payload) == older.renewed_observation(payload, 7) == payload
