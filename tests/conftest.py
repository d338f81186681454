"""Settings of hypothesis: the same examples in every run, and no wall-clock deadline for an example.

A background job of a script ignores stop signals, and children inherit that: tests restore the defaults.
"""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from fes.system.signals import STOP_SIGNALS

settings.register_profile("fes", derandomize=True, deadline=None)
settings.register_profile("quick", settings.get_profile("fes"), max_examples=20)
settings.load_profile("fes")

signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

KINDS = ("unit", "integration", "system", "science", "architecture")
"""Folders of tests, each of which is a marker."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark every test with the name of its folder."""
    folder = Path(__file__).parent
    for item in items:
        for kind in KINDS:
            if folder / kind in item.path.parents:
                item.add_marker(kind)


@pytest.fixture(autouse=True)
def _stop_signals_are_left_alone() -> Iterator[None]:
    """Fail a test that leaves other handlers of stop signals: processes of later tests would inherit them."""
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    after = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    for number, handler in before.items():
        signal.signal(number, handler)
    assert after == before
