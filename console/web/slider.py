"""The time slider of a recorded run: play, pause, speed, and the time that is shown."""

import math

from bokeh.layouts import row
from bokeh.models import Select, Slider, Toggle

SPEEDS = tuple(2.0**power for power in range(-3, 8))
"""Speeds to choose from [simulated seconds per second]."""

PLAY, PAUSE = "Play", "Pause"


class TimeSlider:
    """A position in a run of `duration` [s], in ticks of `dt` [s]."""

    def __init__(self, duration: float, dt: float, speed: float) -> None:
        self._dt, self._end, self._time = dt, max(duration, dt), 0.0
        speeds = sorted({*SPEEDS, speed})
        self._slider = Slider(
            name="time", title="time [s]", start=0.0, end=self._end, step=dt, value=0.0, format="0,0.00",
            sizing_mode="stretch_width",
        )  # fmt: skip
        self._play = Toggle(name="play", label=PAUSE, active=True, width=90, align="end")
        options = [(f"{value:g}", f"{value:g} ×") for value in speeds]
        self._speed = Select(name="speed", title="speed", options=options, value=f"{speed:g}", width=90)
        self.row = row(self._play, self._speed, self._slider, sizing_mode="stretch_width", name="controls")
        self._is_own_move = False
        self._slider.on_change("value", self._moved)
        self._play.on_change("active", self._toggled)

    @property
    def tick(self) -> int:
        """The tick that is shown."""
        return math.floor(self._time / self._dt + 1e-6)

    def advance(self, elapsed: float, known: float) -> None:
        """Advance by `elapsed` [s; wall clock] if it plays, no further than the time that is `known` [s]."""
        if not self._play.active:
            return
        self._time = min(self._time + elapsed * float(self._speed.value), max(known, 0.0), self._end)
        if self._time >= self._end:
            self._play.active = False
        self._is_own_move = True
        self._slider.value = self._time
        self._is_own_move = False

    def _moved(self, name: str, old: float, new: float) -> None:
        if not self._is_own_move:
            self._time = min(max(float(new), 0.0), self._end)

    def _toggled(self, name: str, old: bool, new: bool) -> None:
        self._play.label = PAUSE if new else PLAY
        if new and self._time >= self._end:
            self._time = 0.0
