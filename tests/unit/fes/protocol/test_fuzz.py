"""Mutations of valid payloads: every decoder refuses them in one line or reads them, and does neither for long."""

from random import Random

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.errors import FesError
from fes.protocol import wire
from fes.protocol.channel_change import ChangeResult, encode_result
from tests.support.examples import EXAMPLES
from tests.support.fuzz import attack, corpus
from tests.support.mutations import LENGTHS, MUTATIONS, mutate
from tests.support.payloads import CODECS, refusal
from tests.support.plain_payloads import PLAIN
from world.config import events
from world.config.radio import RadioConfig

NAMES = list(CODECS)
OTHERS = [payloads[0] for payloads in corpus(1).values()]


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=3 * EXAMPLES // 2)
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_a_mutated_payload_is_rejected_or_decodes_to_a_message(name: str, data: st.DataObject, seed: int) -> None:
    random = Random(seed)
    payload = CODECS[name].encode(data.draw(CODECS[name].messages))
    for _ in range(5):
        attack(name, mutate(random, payload, [*OTHERS, payload]))


@pytest.mark.parametrize("name", NAMES)
def test_a_header_that_announces_more_than_the_payload_holds_is_rejected_at_once(name: str) -> None:
    fields = CODECS[name].fields
    for head in LENGTHS:
        for before in (b"", bytes([0x91 + fields, wire.PROTOCOL]), b"\x92\x02", b"\xdd\x00\x00\x00\x02\x02"):
            for after in (b"", bytes(1000)):
                assert refusal(name, before + head + after)


@pytest.mark.parametrize("name", NAMES)
def test_the_longest_payload_is_rejected_within_seconds(name: str) -> None:
    for filler in (b"\x00", b"\x91", b"\xc0", b"\x81\xa1a", b"\xcb" + bytes(8), b"\xff"):
        length = wire.MAX_PAYLOAD // len(filler) - 10
        for head in (b"", b"\xdd" + length.to_bytes(4, "big"), b"\x92\x02\xdd" + length.to_bytes(4, "big")):
            attack(name, head + filler * length)


def test_every_mutation_changes_a_payload() -> None:
    """Each mutation changes the payload at least once in a hundred tries."""
    payload: bytes = msgpack.packb(PLAIN["Beacon"])
    for mutation in MUTATIONS:
        changed = bytearray(payload)
        for seed in range(100):
            mutation(Random(seed), changed, OTHERS)
            if changed != payload:
                break
        assert changed != payload, mutation.__name__


@settings(max_examples=3 * EXAMPLES)
@given(data=st.data())
def test_any_well_formed_change_is_applied_or_rejected_in_one_line(data: st.DataObject) -> None:
    change = data.draw(CODECS["Change"].messages)
    field = data.draw(st.sampled_from([*RadioConfig.model_fields, "shadowing.deviation", "jammers.0.x", "bursts"]))
    path = data.draw(st.sampled_from([change.path, f"channel.{field}", f"channel.{field}.x"]))
    try:
        changed = events.changed(RadioConfig(), {path: change.value}, 0.02)
        text = str(
            CODECS["Effect"].decode(encode_result(ChangeResult(path, events.effective(changed, path), 1, 68.0))).tick
        )
    except FesError as error:
        text = str(error)
    assert 0 < len(text) < 400
    assert text.isprintable()
