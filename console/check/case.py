"""An extension and its short runs."""

from functools import cached_property
from typing import Any

from console.backends import inprocess
from console.check import recorded
from console.check.recorded import Moment
from console.check.subject import ROBOTS, Subject
from console.replay.difference import Difference
from world.config.scenario import Scenario


class Case:
    """An extension and its runs, each of which is made once."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject

    @cached_property
    def scenario(self) -> Scenario:
        """The short run."""
        return self.subject.scenario()

    @cached_property
    def moments(self) -> list[Moment]:
        """The short run in one loop, recorded."""
        return recorded.record(self.scenario)

    @cached_property
    def repetition(self) -> Difference | None:
        """The first difference of a second execution in this process; None if all digits are the same."""
        if self.subject.is_law:
            return recorded.robots(self.scenario, self.moments, range(ROBOTS))
        return recorded.world(self.scenario, self.moments)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Its summary."""
        return inprocess.run(self.scenario, "check")
