"""The first difference of two ticks: numbers to the bit, but not what Commands tell of the robots' processes."""

import numpy as np

from console.replay import difference
from console.replay.difference import Difference
from fes.protocol import messages
from fes.protocol.messages import Command
from fes.recording.layout import TickPayloads

NOTHING = np.zeros(0)


def tick(*commands: bytes) -> TickPayloads:
    """A tick of which only the Commands matter."""
    silent = [b""] * len(commands)
    return TickPayloads(silent, silent, list(commands))


def command(robot: int = 0, linear: float = 0.0, is_model_free: bool | None = None) -> bytes:
    """The payload of a Command of tick 3."""
    links = np.zeros(0, dtype=np.int64)
    return messages.encode_command(
        Command(3, robot, (linear, 0.5), links, NOTHING, NOTHING, is_model_free=is_model_free)
    )


def test_ticks_of_one_loop_and_of_processes_do_not_differ_in_what_is_known_of_the_processes() -> None:
    for first in (None, True, False):
        for second in (None, True, False):
            pair = tick(command(is_model_free=first)), tick(command(is_model_free=second))
            assert difference.between(3, *pair) is None


def test_a_number_that_differs_is_found_behind_such_commands() -> None:
    first = tick(command(is_model_free=True), command(1, 0.0, is_model_free=True))
    second = tick(command(), command(1, -0.0))
    assert difference.between(3, first, second) == Difference(3, "Command", 1, "twist.linear", 0.0, -0.0)
    assert difference.between(3, first, second, robots={0}) is None


def test_a_command_that_is_missing_or_cannot_be_read_differs_from_one_that_is_there() -> None:
    missing = difference.between(3, tick(b""), tick(command()))
    assert missing == Difference(3, "Command", 0, "payload", "missing", "there")
    junk = difference.between(3, tick(b"\xc1"), tick(command()))
    assert junk is not None
    assert junk.field.startswith("payload (Command: is not msgpack")


def test_summaries_differ_in_numbers_of_the_run_and_not_in_what_is_known_of_the_processes() -> None:
    assert (
        difference.of_summaries(3, {"digest": "a", "model_free": None}, {"digest": "a", "model_free": True}) is None
    )
    found = difference.of_summaries(3, {"digest": "a", "model_free": None}, {"digest": "b", "model_free": True})
    assert found == Difference(3, "summary", None, "digest", "a", "b")
