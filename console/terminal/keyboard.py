"""Keys pressed in a terminal."""

import contextlib
import os
import select
import termios
import tty
from types import TracebackType
from typing import Self

from fes.system import signals

LEFT, RIGHT, END = "left", "right", "end of input"

_SEQUENCES = {b"\x1b[C": RIGHT, b"\x1b[D": LEFT, b"\x1bOC": RIGHT, b"\x1bOD": LEFT}


class Keyboard:
    """A terminal that delivers each key at once within a block."""

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal

    def __enter__(self) -> Self:
        self._before = termios.tcgetattr(self._terminal)
        self._restored = signals.if_forced(self._restore)
        self._restored.__enter__()
        tty.setcbreak(self._terminal)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self._restore()
        finally:
            self._restored.__exit__(None, None, None)

    def _restore(self) -> None:
        with contextlib.suppress(termios.error):  # the terminal may be closed
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)

    def pressed(self, timeout: float) -> list[str]:
        """The keys pressed, after a wait of up to `timeout` [s]; END if the terminal is closed."""
        if not select.select([self._terminal], [], [], timeout)[0]:
            return []
        try:
            typed = os.read(self._terminal, 1024)
        except OSError:
            typed = b""
        return keys(typed) if typed else [END]


def keys(typed: bytes) -> list[str]:
    """Typed bytes as keys, without unknown sequences.

    >>> keys(b" +\\x1b[C\\x1b[Aq")
    [' ', '+', 'right', 'q']
    """
    pressed = []
    while typed:
        if typed[:1] == b"\x1b":
            sequence, typed = typed[:3], typed[3:]
            if sequence in _SEQUENCES:
                pressed.append(_SEQUENCES[sequence])
            continue
        pressed.append(chr(typed[0]))
        typed = typed[1:]
    return pressed
