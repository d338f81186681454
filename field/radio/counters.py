"""The counts of a radio: datagrams sent, heard and refused."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class RadioCounters:
    """Datagrams since the radio was opened."""

    sent: int = 0
    unsent: int = 0
    """Those that the system did not accept: no way, or no memory."""
    heard: int = 0
    """Beacons handed on."""
    own: int = 0
    """The robot's own, which the network or a relay returned."""
    overflowed: int = 0
    """Those that this system received and dropped, because the process read too late. They look like losses of the
    radio to a receiver that counts."""
    refused: Counter[str] = field(default_factory=Counter)
    """Those that broke a rule, by rule: one of REFUSALS, REPLAYS or SAME_ROBOT."""
