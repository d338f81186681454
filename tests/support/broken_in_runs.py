"""Extensions whose faults show in a run only: they write to what is not theirs, or fail at one moment."""

from collections.abc import Mapping
from typing import Any

from agents.rivals.fixed_separation import FixedSeparation
from fes.extension import Formed, LinkGeometry, Neighborhood
from tests.support.broken_laws import Law
from tests.support.broken_worlds import Metric


class PushesBodies(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        around.poses[:, 0] += 1.0
        return super().step(state, around, links)


class CentersPoses(Metric):
    def add(self, tick: Any) -> None:
        tick.state.poses[:, :2] -= tick.state.poses[:, :2].mean(axis=0)


class StopsRobots(Metric):
    def add(self, tick: Any) -> None:
        twists = tick.twists
        twists *= 0.0


class RemovesRobot(Metric):
    def add(self, tick: Any) -> None:
        tick.state.present &= False


class RestartsContacts(Metric):
    def add(self, tick: Any) -> None:
        tick.state.radio.age *= 0


class FailsAtOnce(Metric):
    def add(self, tick: Any) -> None:
        raise ValueError("no\nnumbers")


class FailsAtTheEnd(Metric):
    def result(self) -> Mapping[str, float | None]:
        return {"ratio": 1.0 / (self.total - self.total)}


class NegativePeriod(FixedSeparation):
    @staticmethod
    def physical_period(parameters: Any) -> Any:
        return -3.0


class PeriodInWords(FixedSeparation):
    @staticmethod
    def physical_period(parameters: Any) -> Any:
        return "1 s"


class EndlessPeriod(FixedSeparation):
    @staticmethod
    def physical_period(parameters: Any) -> Any:
        return 1e300
