"""An event loop whose clock jumps to the next due event: waiting takes no time and is deterministic."""

import asyncio
from collections.abc import Coroutine
from typing import Any


class Jumping(asyncio.SelectorEventLoop):
    """Loop whose time [s] begins at 0 and moves only when no callback is ready."""

    def __init__(self) -> None:
        super().__init__()
        self._now = 0.0
        selector = self._selector  # type: ignore[attr-defined]
        look = selector.select

        def jump(timeout: float | None = None) -> Any:
            assert timeout is not None, "nothing is due: this would wait for ever"
            events = look(0)
            if not events:
                self._now += timeout
            return events

        selector.select = jump

    def time(self) -> float:
        """Its clock [s]."""
        return self._now


LONGEST = 10_000.0
"""Time [s of the loop] after which a test is considered to wait forever."""


def run(story: Coroutine[Any, Any, Any]) -> Any:
    """Result of a coroutine in a loop of its own."""
    with asyncio.Runner(loop_factory=Jumping) as runner:
        return runner.run(asyncio.wait_for(story, LONGEST))
