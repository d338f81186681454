"""A canvas of braille dots in a terminal: two by four dots per cell, so that a dot is as wide as it is high.

Dots are counted from the lower left, x to the right and y up, like the world's axes.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from rich.segment import Segment
from rich.style import Style

from fes.arrays.types import Bools, Floats, Ints

Line: TypeAlias = list[Segment]

DOTS_X, DOTS_Y = 2, 4
"""Dots per cell."""

_BRAILLE = 0x2800
_BLANK = ord(" ")
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]], dtype=np.uint32)


class Canvas:
    """Dots, and characters over them. In a cell that drawings share, the later palette entry wins."""

    def __init__(self, width: int, height: int, palette: Sequence[str]) -> None:
        self.width, self.height = width, height
        self.palette = [Style.parse(style) for style in palette]
        self.dots: Bools = np.zeros((height * DOTS_Y, width * DOTS_X), dtype=np.bool_)
        self.ink: Ints = np.zeros((height, width), dtype=np.int64)
        self.characters: NDArray[np.uint32] = np.zeros((height, width), dtype=np.uint32)

    def points(self, x: Floats, y: Floats, ink: Ints) -> None:
        """Set the dots nearest to (x, y) [k], in entry `ink` of the palette; dots outside are clipped."""
        column, row = _nearest(x), _nearest(y)
        row = self.height * DOTS_Y - 1 - row
        inside = (column >= 0) & (column < self.width * DOTS_X) & (row >= 0) & (row < self.height * DOTS_Y)
        column, row = column[inside], row[inside]
        self.dots[row, column] = True
        np.maximum.at(self.ink, (row // DOTS_Y, column // DOTS_X), ink[inside])

    def lines(self, start: Floats, end: Floats, ink: Ints, dash: Ints) -> None:
        """Draw lines from `start` to `end` [k, 2]: of every dash[:, 1] dots the first dash[:, 0]."""
        origin = _nearest(start)
        extent = _nearest(end) - origin
        steps = np.maximum(1, np.abs(extent).max(axis=1, initial=0))
        line = np.repeat(np.arange(len(steps)), steps + 1)
        first = np.cumsum(steps + 1) - (steps + 1)
        step = np.arange(len(line)) - first[line]
        line, step = (values[step % dash[line, 1] < dash[line, 0]] for values in (line, step))
        positions = origin[line] + extent[line] * (step / steps[line])[:, None]
        self.points(positions[:, 0], positions[:, 1], ink[line])

    def cell(self, x: Floats, y: Floats) -> tuple[Ints, Ints]:
        """Column and row, counted from the top, of the cells that hold the dots nearest to (x, y)."""
        column, row = _nearest(x), _nearest(y)
        return column // DOTS_X, self.height - 1 - row // DOTS_Y

    def write(self, column: int, row: int, text: str, ink: int) -> None:
        """Put `text` over the dots, from a cell to the right; characters outside are clipped."""
        for cell, character in enumerate(text, column):
            if 0 <= cell < self.width and 0 <= row < self.height:
                self.characters[row, cell] = ord(character)
                self.ink[row, cell] = ink

    def is_free(self, column: int, row: int, length: int, of_dots: bool) -> bool:
        """True if `length` cells are on the canvas and hold no character and, with `of_dots`, no dot."""
        if not (0 <= row < self.height and column >= 0 and column + length <= self.width):
            return False
        if self.characters[row, column : column + length].any():
            return False
        top, left = row * DOTS_Y, column * DOTS_X
        return not (of_dots and self.dots[top : top + DOTS_Y, left : left + length * DOTS_X].any())

    def render(self) -> list[Line]:
        """The canvas as lines of styled text."""
        cells = self.dots.reshape(self.height, DOTS_Y, self.width, DOTS_X).astype(np.uint32)
        code = np.einsum("iajb,ab->ij", cells, _BITS).astype(np.uint32)
        code = np.where(code > 0, code + _BRAILLE, _BLANK)
        code = np.where(self.characters > 0, self.characters, code).astype("<u4")
        return [self._line(code[row], np.where(code[row] == _BLANK, 0, self.ink[row])) for row in range(self.height)]

    def _line(self, code: NDArray[np.uint32], ink: Ints) -> Line:
        text = code.tobytes().decode("utf-32-le")
        cuts = [0, *(np.flatnonzero(ink[1:] != ink[:-1]) + 1).tolist(), len(text)]
        return [Segment(text[first:last], self.palette[ink[first]]) for first, last in pairwise(cuts) if first < last]


def _nearest(position: Floats) -> Ints:
    """Nearest integers; `rint` rounds halves to even, which would leave gaps in a line."""
    nearest: Ints = np.floor(position + 0.5).astype(np.int64)
    return nearest
