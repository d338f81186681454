"""An event loop whose clock jumps to what is due next: minutes of waiting take no time, and are always the same."""

import asyncio
from collections.abc import Coroutine
from typing import Any


class Jumping(asyncio.SelectorEventLoop):
    """Its time [s] begins at 0 and moves only while nothing else is to be done."""

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
"""What is not over by then [s of the loop] waits for ever."""


def run(story: Coroutine[Any, Any, Any]) -> Any:
    """What a story comes to, in a loop of its own."""
    with asyncio.Runner(loop_factory=Jumping) as runner:
        return runner.run(asyncio.wait_for(story, LONGEST))
