"""Mutations of a valid payload, as from a hostile or broken sender."""

from collections.abc import Callable
from random import Random
from typing import Any

import msgpack

ODD: list[Any] = [
    *(None, True, False, 0, -1, 2**31, 2**53, 2**63, 2**64 - 1, -(2**63), 0.0, -0.0, 1e308, 5e-324),
    *(float("nan"), float("inf"), float("-inf"), "", "NaN", "\x00", "é" * 50, b"", b"\xff" * 7, b"\0" * 64),
    *([], [[]], [1] * 100, {}, {"a": 1}, [None] * 13, "[" * 2000, msgpack.ExtType(5, b"x"), msgpack.Timestamp(1, 5)),
]
"""Values that few fields or none expect."""

LENGTHS = [
    *(b"\xdc\xff\xff", b"\xdd\xff\xff\xff\xff", b"\xdd\x7f\xff\xff\xff", b"\xde\xff\xff", b"\xdf\xff\xff\xff\xff"),
    *(b"\xc4\xff", b"\xc5\xff\xff", b"\xc6\xff\xff\xff\xff", b"\xdb\xff\xff\xff\xff", b"\xc9\xff\xff\xff\xff\x05"),
]
"""Heads of arrays, maps, binaries, texts and extensions that promise more than there is."""


def flip(random: Random, payload: bytearray, others: list[bytes]) -> None:
    for _ in range(random.choice((1, 1, 2, 8))):
        payload[random.randrange(len(payload))] ^= 1 << random.randrange(8)


def truncate(random: Random, payload: bytearray, others: list[bytes]) -> None:
    del payload[random.randrange(len(payload)) :]


def splice(random: Random, payload: bytearray, others: list[bytes]) -> None:
    donor = random.choice(others)
    payload[random.randrange(len(payload)) :] = donor[random.randrange(len(donor)) :]


def duplicate(random: Random, payload: bytearray, others: list[bytes]) -> None:
    begin = random.randrange(len(payload))
    part = payload[begin : begin + random.randrange(1, 40)]
    index = random.randrange(len(payload))
    payload[index:index] = part * random.choice((1, 2, 500))


def promise(random: Random, payload: bytearray, others: list[bytes]) -> None:
    index = random.randrange(len(payload))
    payload[index : index + random.randrange(6)] = random.choice(LENGTHS)


def swap_types(random: Random, payload: bytearray, others: list[bytes]) -> None:
    fields = _fields(payload)
    for _ in range(random.choice((1, 1, 2, 3))):
        if fields:
            fields[random.randrange(len(fields))] = random.choice(ODD)
    payload[:] = msgpack.packb(fields)


def swap_fields(random: Random, payload: bytearray, others: list[bytes]) -> None:
    fields, foreign = _fields(payload), _fields(bytearray(random.choice(others)))
    if fields and foreign:
        fields[random.randrange(len(fields))] = random.choice(foreign)
        if random.random() < 0.3:
            random.shuffle(fields)
    payload[:] = msgpack.packb(fields)


def damage_blob(random: Random, payload: bytearray, others: list[bytes]) -> None:
    """Keep the layout, and change the bytes of ids or numbers."""
    fields = _fields(payload)
    blobs = [index for index, value in enumerate(fields) if type(value) is bytes and value]
    if blobs:
        index = random.choice(blobs)
        blob = bytearray(fields[index])
        random.choice((flip, truncate, duplicate))(random, blob, others)
        fields[index] = bytes(blob)
        payload[:] = msgpack.packb(fields)


def nest(random: Random, payload: bytearray, others: list[bytes]) -> None:
    index = random.randrange(len(payload))
    payload[index:index] = random.choice((b"\x91", b"\x81\xa1a", b"\xdc\x00\x01")) * random.choice((3, 600, 5000))


MUTATIONS: list[Callable[[Random, bytearray, list[bytes]], None]] = [
    *(flip, truncate, splice, duplicate, promise, swap_types, swap_fields, damage_blob, nest)
]


def mutate(random: Random, payload: bytes, others: list[bytes]) -> bytes:
    """The payload after one to four mutations; `others` are payloads to splice it with."""
    mutated = bytearray(payload)
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        if not mutated:
            break
        random.choice(MUTATIONS)(random, mutated, others)
    return bytes(mutated)


def _fields(payload: bytearray) -> list[Any]:
    try:
        fields = msgpack.unpackb(bytes(payload))
    except Exception:  # already mutated
        return []
    return fields if isinstance(fields, list) else [fields]
