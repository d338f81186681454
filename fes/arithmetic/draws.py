"""Random numbers as a function of (seed, stream, tick, sender, receiver), and of nothing else.

Philox is a counter-based generator: the number at a counter does not depend on the numbers drawn before. So the order
of arrival, the placement of robots and the load of the machine change no draw. An additional robot changes no draw of
the others, and another controller changes no draw of the channel.
"""

import hashlib
import math
from collections.abc import Iterator

import numpy as np

from fes.arithmetic.core import functions
from fes.arrays.types import Floats, Ints

_PER_COUNTER = 4  # Philox 4x64 gives four words at each counter value
_TO_UNIT = math.ldexp(1.0, -53)
_AT_ONCE = 2**16


def key(seed: int, stream: str) -> Ints:
    """The generator's key [2] of a named stream of a seed, so that no two streams share numbers."""
    digest = hashlib.sha256(f"{seed}/{stream}".encode()).digest()
    return np.frombuffer(digest[:16], dtype=np.uint64).copy()  # type: ignore[return-value]


def sub_seed(seed: int, stream: str) -> int:
    """A seed in [0, 2**53) for a process that must not be able to infer `seed` from it."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{stream}/sub".encode()).digest()[:8], "little") >> 11


def uniform_ticks(stream_key: Ints, first: int, count: int, senders: Ints, receivers: Ints) -> Floats:
    """Uniform numbers in [0, 1) for `count` ticks from `first` on, for each (sender, receiver).

    Shapes: senders and receivers [m]; the result [count, m], contiguous by tick. `first` and `count` must
    be multiples of 4.
    """
    if first % _PER_COUNTER or count % _PER_COUNTER:
        raise ValueError(f"ticks come in blocks of {_PER_COUNTER}: first={first}, count={count}")
    numbers: Floats
    if (core := functions.load()) is not None:
        numbers = np.empty((count, len(senders)))
        for row, tick in enumerate(range(first, first + count)):
            numbers[row] = core.random_numbers(stream_key, tick, senders, receivers)
        return numbers
    words = np.empty((count, len(senders)), dtype=np.uint64)
    counter = np.zeros(4, dtype=np.uint64)
    generator = np.random.Philox(key=stream_key, counter=counter)
    state = generator.state
    counter = state["state"]["counter"]
    for column, (sender, receiver) in enumerate(zip(senders.tolist(), receivers.tolist(), strict=True)):
        # The generator increments its counter before it generates words.
        counter[:] = (first // _PER_COUNTER, sender, receiver, 0)
        generator.state = state
        words[:, column] = generator.random_raw(count)
    # In place, some ticks at a time: in a large team, temporary copies would triple a large array.
    words >>= np.uint64(11)
    numbers = words.view(np.float64)
    rows = max(1, _AT_ONCE // max(1, len(senders)))
    for row in range(0, count, rows):
        np.multiply(words[row : row + rows], _TO_UNIT, out=numbers[row : row + rows])
    return numbers


def words(stream_key: Ints, tick: int, robot: int) -> Iterator[int]:
    """Random 64-bit words without an end, for a robot at a tick."""
    generator = np.random.Philox(key=stream_key, counter=np.array([0, tick, robot, 0], dtype=np.uint64))
    while True:
        yield from generator.random_raw(_PER_COUNTER).tolist()


def uniform_pairs(stream_key: Ints, senders: Ints, receivers: Ints) -> Floats:
    """One uniform number in [0, 1) for each (sender, receiver) [m]."""
    numbers: Floats = uniform_ticks(stream_key, 0, _PER_COUNTER, senders, receivers)[0]
    return numbers
