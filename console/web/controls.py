"""The controls that change the channel of a running run, as `fes set` does."""

import html
from collections.abc import Awaitable, Callable
from typing import Any

from bokeh.document import Document
from bokeh.layouts import row
from bokeh.models import Button, Div, Select, TextInput

from fes.errors import FesError
from fes.system.output import printable
from world.config.scenario import parse_override

UNITS = {
    "reference_snr": "1",
    "path_loss_exponent": "1",
    "spectral_efficiency": "bit/s/Hz",
    "reference_distance": "m",
    "communication_range": "m",
    "logistic_midpoint": "m",
    "logistic_width": "m",
    "shadowing.deviation": "dB",
}
"""Fields of the channel that a page offers, and their units."""

LONGEST = 100
"""Longest value that a person can type [characters]."""

Send = Callable[[str, Any], Awaitable[str]]
"""Sends a field and its value to the world; returns the answer in words. Raises FesError."""


class Controls:
    """A field, its value, a button, and the world's answer."""

    def __init__(self, document: Document, send: Send) -> None:
        self._document, self._send = document, send
        fields = [(name, f"{name} [{unit}]") for name, unit in UNITS.items()]
        self._field = Select(name="field", title="channel", options=fields, value=fields[0][0], width=210)
        self._value = TextInput(name="value", title="new value", width=110, max_length=LONGEST)
        self._button = Button(name="set", label="Set", button_type="primary", width=70, align="end")
        self._answer = Div(name="answer", text="", align="end", sizing_mode="stretch_width")
        widgets = (self._field, self._value, self._button, self._answer)
        self.row = row(*widgets, sizing_mode="stretch_width", name="controls")
        self._button.on_click(self._press)

    def _press(self) -> None:
        self._button.disabled = True  # until the world answers
        self._document.add_next_tick_callback(self._request)

    async def _request(self) -> None:
        try:
            path, value = parse_override(f"channel.{self._field.value}={self._value.value.strip()[:LONGEST]}")
            self._answer.text = html.escape(printable(await self._send(path, value)))
        except FesError as error:
            self._answer.text = html.escape(printable(f"refused: {error}"))
        finally:
            self._button.disabled = False
