"""A long call in a thread, interrupted while the thread starts."""

import _thread
import threading

import pytest

from console.api import background
from console.api.background import Work
from fes.errors import Stopped
from tests.support.processes import PATIENCE


@pytest.mark.parametrize("runs", [True, False])
def test_an_interrupt_while_the_thread_starts_is_raised_and_stops_the_work(
    runs: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python has an id for the thread, and does not yet know that it has started: a join raises RuntimeError."""
    work, ended = Work(), threading.Event()

    class Starting(threading.Thread):
        @property
        def ident(self) -> int:
            return 1

        def start(self) -> None:
            if runs:
                _thread.start_new_thread(self.run, ())
            raise KeyboardInterrupt

    def steps() -> None:
        try:
            while True:
                work.pause(0.001)
        finally:
            ended.set()

    monkeypatch.setattr("console.api.background.threading.Thread", Starting)
    with pytest.raises(KeyboardInterrupt):
        background.call(work, steps, None)
    with pytest.raises(Stopped):
        work.check()
    assert ended.wait(PATIENCE) if runs else not ended.is_set()
