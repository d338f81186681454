"""How often, and how soon, an agent that died is started again: never in a tight loop, and not for ever."""

from dataclasses import dataclass, field

FIRST_DELAY = 0.5
"""Before an agent is started again for the first time [s]; each short life in a row doubles it."""

SHORT = 30.0
"""An agent that lived for less than this [s] had a short life."""

MOST = 5
"""After so many short lives in a row an agent is started again; after one more it is not."""


@dataclass
class Respawn:
    """The agents of one run, by what their `--id` says."""

    _short: dict[str, int] = field(default_factory=dict)
    """Short lives in a row."""

    def delay(self, robots: str, lived: float) -> float | None:
        """How long to wait [s] before the agent of `robots`, which `lived` so long [s], is started again.

        None if it is given up: it died too often.

        >>> agents = Respawn()
        >>> [agents.delay("3", lived=1.0) for _ in range(6)]
        [0.5, 1.0, 2.0, 4.0, 8.0, None]
        >>> agents.delay("4", lived=1.0), agents.delay("4", lived=1.0), agents.delay("4", lived=60.0)
        (0.5, 1.0, 0.5)
        """
        short = self._short.get(robots, 0) + 1 if lived < SHORT else 1
        self._short[robots] = short
        return FIRST_DELAY * 2.0 ** (short - 1) if short <= MOST else None
