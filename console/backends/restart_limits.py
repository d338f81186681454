"""Limits on restarts of agents that died: increasing delays, and a largest number."""

from dataclasses import dataclass, field

FIRST_DELAY = 0.5
"""Delay before the first restart of an agent [s]; each short life in a row doubles it."""

SHORT = 30.0
"""A life shorter than this [s] is a short one."""

MOST = 5
"""Largest number of short lives in a row after which an agent is still restarted."""


@dataclass
class RestartLimit:
    """Short lives of the agents of one run, by their `--id`."""

    _short: dict[str, int] = field(default_factory=dict)
    """Number of short lives in a row."""

    def delay(self, robots: str, lived: float) -> float | None:
        """Delay [s] before the agent of `robots`, which `lived` this long [s], is restarted.

        None if it died too often to be restarted.

        >>> agents = RestartLimit()
        >>> [agents.delay("3", lived=1.0) for _ in range(6)]
        [0.5, 1.0, 2.0, 4.0, 8.0, None]
        >>> agents.delay("4", lived=1.0), agents.delay("4", lived=1.0), agents.delay("4", lived=60.0)
        (0.5, 1.0, 0.5)
        """
        short = self._short.get(robots, 0) + 1 if lived < SHORT else 1
        self._short[robots] = short
        return FIRST_DELAY * 2.0 ** (short - 1) if short <= MOST else None
