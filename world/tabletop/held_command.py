"""The rules by which a vendor's driver obeys: pure, as payloads and times come in as arguments.

A driver obeys the last command that it could read. It holds that command forever unless it has a timeout: so do the
drivers of many robots, such as TurtleBot 3 (ROBOTIS-GIT/turtlebot3#1154). Commands that it cannot read are ignored
without a word: a message of another type, and in the style rmw_zenoh a message without an attachment.
"""

from typing import NamedTuple

from fes.errors import MessageError
from fes.ros import messages, topics
from world.config.hardware.tabletop import TabletopConfig

AT_REST = (0.0, 0.0)


class Arrival(NamedTuple):
    """A sample on the key of a robot's commands."""

    time: float
    """Time of its arrival [s; monotonic]."""
    payload: bytes
    attachment: bytes


class HeldCommand:
    """The command that a driver holds."""

    def __init__(self, config: TabletopConfig) -> None:
        self._config = config
        self._twist, self._since = AT_REST, 0.0
        self.obeyed = 0
        """Commands that it has obeyed."""
        self.ignored = 0
        """Samples that it could not read."""

    def hear(self, arrival: Arrival) -> None:
        """Obey a command, or ignore it."""
        if self._config.style == "rmw_zenoh" and topics.read_attachment(arrival.attachment) is None:
            self.ignored += 1
            return
        try:
            self._twist = messages.read_twist(self._config.command_type, arrival.payload)
        except MessageError:
            self.ignored += 1
            return
        self._since = arrival.time
        self.obeyed += 1

    def twist(self, now: float) -> tuple[float, float]:
        """The twist that it tells its motors at the time `now` [s; monotonic] [m/s, rad/s; body frame]."""
        timeout = self._config.driver_timeout
        return self._twist if timeout is None or now - self._since <= timeout else AT_REST
