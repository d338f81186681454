"""A wall clock that moves only during sleeps on it."""

from collections.abc import Callable

import pytest


class Clock:
    """Replaces the clock and the sleep of a module; sleep number i takes `longer(i)` [s] more than requested."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, module: str, longer: Callable[[int], float]) -> None:
        self.now, self.slept = 100.0, list[float]()
        self._longer = longer
        monkeypatch.setattr(f"{module}.time.monotonic", lambda: self.now)
        monkeypatch.setattr(f"{module}.asyncio.sleep", self._sleep)

    async def _sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds + self._longer(len(self.slept))
