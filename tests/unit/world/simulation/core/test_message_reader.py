"""The core reads the messages that `fes.protocol.messages` reads, and leaves all others to it."""

import random

import numpy as np
import pytest

from fes.errors import MessageError
from fes.protocol import messages
from fes.protocol.messages import Beacon, Command
from world.simulation.core import message_reader
from world.simulation.core.message_reader import MessageReader

ROBOTS, TICK = 10, 70_000
SENDERS = list(range(ROBOTS))
BYTES = (0, 1, 0x7F, 0xC0, 0xC2, 0xC4, 0xCB, 0xFF)
"""Bytes with a meaning in msgpack or in a number."""


@pytest.fixture
def reader() -> MessageReader:
    created = message_reader.of(ROBOTS)
    if created is None:
        pytest.skip("the core is not built")
    return created


def command(robot: int, tick: int = TICK) -> bytes:
    """A command with as many links as the robot's id modulo 4."""
    count = robot % 4
    numbers = np.linspace(-3.0, 70.0, 3 * count)
    details = np.array([0.5] * (robot % 3))
    free = [None, True, False][robot % 3]
    links = np.arange(count) + 5
    return messages.encode_command(
        Command(tick, robot, (1.5, -2.5), links, numbers[:count], numbers[count:], details, free)
    )


def beacon(robot: int, tick: int = TICK) -> bytes:
    """A beacon with as many links as the robot's id modulo 4."""
    count = robot % 4
    numbers, selected = np.linspace(-3.0, 70.0, count), np.ones(count, np.uint8)
    links, statistics = np.arange(count) + 5, np.array([1.0, 2.0] * (robot % 2))
    return messages.encode_beacon(Beacon(tick, robot, (1.0, 2.0, 3.0), links, numbers, selected, statistics, b"own"))


def assert_equal(read: Command, decoded: Command) -> None:
    for field, value, expected in zip(Command._fields, read, decoded, strict=True):
        assert type(value) is type(expected), field
        assert np.array_equal(value, expected), field  # type: ignore[arg-type]


def changed(payload: bytes, numbers: random.Random) -> bytes:
    """The payload with one or two other bytes, or cut off."""
    if numbers.random() < 0.1:
        return payload[: numbers.randrange(len(payload))]
    data = bytearray(payload)
    for _ in range(numbers.choice((1, 1, 2))):
        data[numbers.randrange(len(data))] = numbers.choice((*BYTES, numbers.randrange(256)))
    return bytes(data)


def test_the_commands_are_those_of_the_decoder(reader: MessageReader) -> None:
    payloads = [command(robot) for robot in SENDERS]
    read = reader.commands(TICK, SENDERS, payloads)
    assert read is not None
    for one, payload in zip(read, payloads, strict=True):
        assert_equal(one, messages.decode_command(payload))


def test_more_commands_than_robots_are_read(reader: MessageReader) -> None:
    read = reader.commands(TICK, [3] * 25, [command(3)] * 25)
    assert read is not None
    assert [one.robot for one in read] == [3] * 25


@pytest.mark.parametrize("strange", [command(4, TICK + 1), command(5), b"", beacon(4), command(4)[:-1]])
def test_one_strange_command_leaves_all_to_the_decoder(reader: MessageReader, strange: bytes) -> None:
    payloads = [strange if robot == 4 else command(robot) for robot in SENDERS]
    assert reader.commands(TICK, SENDERS, payloads) is None


@pytest.mark.parametrize("strange", [beacon(4, TICK - 1), beacon(5), b"", command(4), beacon(4)[:-1]])
def test_one_strange_beacon_leaves_all_to_the_decoder(reader: MessageReader, strange: bytes) -> None:
    assert reader.are_beacons(TICK, SENDERS, [beacon(robot) for robot in SENDERS])
    assert not reader.are_beacons(TICK, SENDERS, [strange if robot == 4 else beacon(robot) for robot in SENDERS])


def test_links_to_robots_that_do_not_exist_are_left_to_the_decoder() -> None:
    small = message_reader.of(7)
    if small is None:
        pytest.skip("the core is not built")
    assert small.commands(TICK, [2], [command(2)]) is not None
    assert small.commands(TICK, [3], [command(3)]) is None
    assert small.are_beacons(TICK, [2], [beacon(2)])
    assert not small.are_beacons(TICK, [3], [beacon(3)])


def test_the_decoder_takes_each_damaged_message_that_the_core_takes(reader: MessageReader) -> None:
    numbers, taken = random.Random(1), 0
    for _ in range(3000):
        robot = numbers.randrange(ROBOTS)
        order, heard = changed(command(robot), numbers), changed(beacon(robot), numbers)
        read = reader.commands(TICK, [robot], [order])
        if read is not None:
            taken += 1
            assert_equal(read[0], messages.decode_command(order))
        if reader.are_beacons(TICK, [robot], [heard]):
            taken += 1
            assert messages.decode_beacon(heard)[:2] == (TICK, robot)
    assert taken > 100


def test_the_decoder_rejects_what_the_core_leaves_of_large_numbers(reader: MessageReader) -> None:
    huge = messages.encode_command(
        Command(TICK, 1, (1.0, 2.0), np.array([5]), np.array([1e13]), np.zeros(0), np.zeros(0))
    )
    assert reader.commands(TICK, [1], [huge]) is None
    with pytest.raises(MessageError):
        messages.decode_command(huge)
