"""Messages of a log, decoded and checked, and second executions that differ from them."""

from collections.abc import Callable, Iterable
from typing import Protocol, TypeVar

from console.replay.difference import Difference
from console.replay.log import Log
from fes.errors import FesError, MessageError
from fes.protocol import world_info
from fes.protocol.messages import Beacon, Command, Observation
from fes.recording.ticks import LoggedTick
from fes.system import fingerprint

T = TypeVar("T", Observation, Beacon, Command)


class Recorded(Protocol):
    """A log, of a run or of a robot."""

    @property
    def origin(self) -> str:
        """Version of fes and arithmetic of the process that recorded it."""


class Mismatch(FesError):
    """A second execution differs from the log. A note shows whether another version of fes may be the cause."""

    def __init__(self, log: Recorded, difference: Difference | str) -> None:
        super().__init__(
            difference if isinstance(difference, str) else difference.describe("in the log", "executed again")
        )
        self.add_note(f"recorded by {log.origin}; executed by {own_origin()}")


def own_origin() -> str:
    """Version of fes and arithmetic of this process."""
    return fingerprint.origin(world_info.version())


def has_own_digits(log: Log) -> bool:
    """True if the arithmetic of a log is that of this process: a second execution of an unedited log is equal."""
    return fingerprint.text(log.arithmetic) == fingerprint.text()


def other_digits(log: Log) -> str | None:
    """Note on a log whose second execution is shown without a comparison; None if the digits are this process's."""
    if has_own_digits(log):
        return None
    return f"{log.path} was recorded by {log.origin}; this is {own_origin()}: the last digits shown may differ"


def decoded(
    tick: LoggedTick, decode: Callable[[bytes], T], payloads: list[bytes], robots: Iterable[int], held: bool = False
) -> list[T]:
    """The messages of some robots at a tick; raises FesError where one is missing, damaged or of another robot.

    With `held` they may be of earlier ticks.
    """
    decoded = []
    for robot in robots:
        try:
            message = decode(payloads[robot])
            name = type(message).__name__
            is_due = message.tick <= tick.number if held else message.tick == tick.number
            if not is_due or message.robot != robot:
                raise MessageError(name, "is of another tick or robot", f"tick {message.tick}, robot {message.robot}")
            peers = message.in_range if isinstance(message, Observation) else message.links
            if len(peers) and not 0 <= peers.min() <= peers.max() < len(payloads):
                raise MessageError(name, f"names a robot that is not one of {len(payloads)}", str(peers.tolist()))
        except MessageError as error:
            raise FesError(f"tick {tick.number}, robot {robot}: {error}") from None
        decoded.append(message)
    return decoded
