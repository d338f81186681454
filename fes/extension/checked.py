"""Checks of the values that an extension returns: one line names the extension, the rule and the value."""

from collections.abc import Callable, Mapping
from typing import Any, NoReturn, TypeVar

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints, read_only
from fes.errors import FesError
from fes.extension.context import LawContext
from fes.extension.neighborhood import Entry, LinkGeometry, Neighborhood
from fes.extension.protocols import Formed, Published
from fes.model.contacts import Contacts
from fes.model.sensing import MAX_DECLARED, MAX_DETAILS, MAX_LEARNT, MAX_STATISTICS

T = TypeVar("T")


class Checked:
    """An extension, and the name by which its errors speak of it."""

    def __init__(self, inner: Any, name: str) -> None:
        self.inner, self._name = inner, name
        self.Parameters = inner.Parameters

    def fail(self, rule: str) -> NoReturn:
        """Raise the FesError of a broken rule."""
        raise FesError(f"{self._name}: {rule}")

    def call(self, method: Callable[..., T], *arguments: Any) -> T:
        """The result of a method; an error in it becomes a FesError of one line."""
        try:
            return method(*arguments)
        except FesError:
            raise
        except Exception as error:  # the code is anybody's
            text = " ".join(str(error).split())
            place = getattr(method, "__name__", type(method).__name__)
            self.fail(f"{place}: {type(error).__name__}" + (f": {text:.200}" if text else ""))

    def array(
        self, what: str, values: Any, shape: tuple[int, ...], kind: Any = np.float64, *, is_partial: bool = False
    ) -> Any:
        """The values, if they are an array of this shape and kind, and finite; NaN is a gap if `is_partial`."""
        if type(values) is not np.ndarray:  # a subclass may have other operators
            self.fail(f"{what} must be an array of shape {_text(shape)}, got {type(values).__name__}")
        if values.shape != shape:
            self.fail(f"{what} must have shape {_text(shape)}, got {_text(values.shape)}")
        if values.dtype != kind:
            self.fail(f"{what} must be of type {np.dtype(kind).name}, got {values.dtype.name}")
        if kind is np.float64:
            wrong = values[np.isinf(values) if is_partial else ~np.isfinite(values)]
            if wrong.size:
                self.fail(f"{what} must be finite, got {wrong.flat[0]}")
        return values

    def number(self, name: str, most: int) -> int:
        """The whole number that a class states, 0 if it states none; a message holds no more than `most`."""
        value = getattr(self.inner, name, 0)
        if type(value) is not int or not 0 <= value <= most:
            self.fail(f"`{name}` must be a whole number from 0 to {most}, got {value!r:.60}")
        return value

    def names(self, name: str, most: int) -> tuple[str, ...]:
        """The names that a class states, none by default; a message holds no more than `most`."""
        value = getattr(self.inner, name, ())
        if not isinstance(value, tuple) or not all(isinstance(entry, str) for entry in value):
            self.fail(f"`{name}` must be a tuple of names, got {value!r:.60}")
        if len(value) > most:
            self.fail(f"`{name}` must hold at most {most} names, got {len(value)}")
        return value


class CheckedRule(Checked):
    """A neighbor rule."""

    def __call__(self, contacts: Contacts) -> Bools:
        """True for each contact that its robot selects [m]."""
        chosen = self.call(self.inner, contacts)
        selected: Bools = self.array("the selection", chosen, (len(contacts.edges),), np.bool_)
        return selected & contacts.known


class CheckedFormation(Checked):
    """A formation law."""

    def __init__(self, inner: Any, name: str, context: LawContext) -> None:
        super().__init__(inner, name)
        self._n = len(context.ids)
        self.declared, self.details = self.number("declared", MAX_DECLARED), self.names("details", MAX_DETAILS)

    def start(self) -> Any:
        """The state before the first tick."""
        return self.call(self.inner.start)

    def forget(self, state: Any, restarted: Bools) -> Any:
        """The state in which the robots `restarted` [n] begin anew."""
        return self.call(self.inner.forget, state, restarted)

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull of each robot at this tick."""
        formed = self.call(self.inner.step, state, around, links)
        if not isinstance(formed, Formed):
            self.fail(f"step must return a Formed, got {type(formed).__name__}")
        self.array("the pull", formed.pull, (self._n, 2))
        if formed.declared is not None or self.declared:
            self.array("the declared bytes", formed.declared, (self._n, self.declared), np.uint8)
        if formed.details is not None or self.details:
            self.array("the details", formed.details, (self._n, len(self.details)))
        if formed.twists is not None:
            self.array("the twists", formed.twists, (self._n, 2), is_partial=True)
        if formed.quality_weight is not None:
            weight = self.array("the quality weight", formed.quality_weight, (self._n,))
            if not (weight > 0.0).all():
                self.fail(f"the quality weight must be positive, got {weight[weight <= 0.0][0]:g}")
        return formed


class CheckedSeeking(Checked):
    """A seeking law."""

    def __init__(self, inner: Any, name: str, context: LawContext) -> None:
        super().__init__(inner, name)
        self._n = len(context.ids)
        self.knows_channel = bool(getattr(inner, "knows_channel", False))
        self.statistics = self.number("statistics", MAX_STATISTICS)
        self.declared = self.number("declared", MAX_DECLARED)
        self.learnt = self.names("learnt", MAX_LEARNT)
        if callable(getattr(inner, "estimates", None)):
            self.estimates = self._estimates

    def start(self) -> Any:
        """The state before the first tick."""
        return self.call(self.inner.start)

    def forget(self, state: Any, restarted: Bools, old: Edges, new: Edges) -> Any:
        """The state in which the robots `restarted` [n] begin anew."""
        return self.call(self.inner.forget, state, restarted, old, new)

    def relink(self, state: Any, old: Edges, new: Edges, entry: Entry) -> Any:
        """The state over the links `new`."""
        return self.call(self.inner.relink, state, old, new, entry)

    def desired(self, state: Any, tick: int, links: Edges) -> Floats:
        """The separation to which each link is driven [l] [m]."""
        desired: Floats = self.array(
            "the desired separation", self.call(self.inner.desired, state, tick, links), (len(links),)
        )
        return desired

    def _estimates(self, state: Any, links: Edges) -> Floats:
        """The desired separations without the dither [l] [m]."""
        estimates: Floats = self.array("the estimates", self.call(self.inner.estimates, state, links), (len(links),))
        return estimates

    def measure(self, state: Any, around: Neighborhood, formed: Formed) -> Any:
        """The state after the beacons of the previous tick."""
        return self.call(self.inner.measure, state, around, formed)

    def publish(self, state: Any, links: Edges) -> Published:
        """The values for beacons and observers at this tick."""
        published = self.call(self.inner.publish, state, links)
        if not isinstance(published, Published):
            self.fail(f"publish must return a Published, got {type(published).__name__}")
        self.array("the estimates", published.estimates, (len(links),))
        self.array("the statistics", published.statistics, (self._n, self.statistics))
        self.array("the learnt numbers", published.learnt, (len(self.learnt), len(links)))
        if published.declared is not None or self.declared:
            self.array("the declared bytes", published.declared, (self._n, self.declared), np.uint8)
        return published

    def seek(self, state: Any, around: Neighborhood) -> Any:
        """The state one tick later."""
        return self.call(self.inner.seek, state, around)


class CheckedChannel(Checked):
    """A channel of reception probability by separation."""

    def probability(self, separation: Floats) -> Floats:
        """Probability that a beacon decodes at `separation` [m], of the same shape."""
        return _shares(self, self.call(self.inner.probability, separation), separation.shape)


class CheckedPairChannel(Checked):
    """A channel of reception probability by pair and time."""

    def pair_probability(self, time: float, senders: Ints, receivers: Ints, separation: Floats) -> Floats:
        """Probability that a beacon of `time` [s] decodes, for each pair of ids [m]."""
        result = self.call(self.inner.pair_probability, time, senders, receivers, separation)
        return _shares(self, result, senders.shape)


def checked_channel(inner: Any, name: str, context: Any) -> Checked:
    """A channel of either kind."""
    if hasattr(inner, "pair_probability"):
        return CheckedPairChannel(inner, name)
    if not hasattr(inner, "probability"):
        Checked(inner, name).fail("it has neither `probability` nor `pair_probability`")
    return CheckedChannel(inner, name)


class CheckedDynamics(Checked):
    """The dynamics of bodies."""

    def __init__(self, inner: Any, name: str, robots: int) -> None:
        super().__init__(inner, name)
        self._n = robots

    def start(self, poses: Floats) -> Any:
        """The state of bodies at rest at `poses` [n, 3]."""
        return self.call(self.inner.start, poses)

    def step(self, state: Any, twists: Floats, dt: float) -> Any:
        """The state after bodies were told to hold `twists` [n, 2] for `dt` [s]."""
        return self.call(self.inner.step, state, read_only(twists), dt)

    def poses(self, state: Any) -> Floats:
        """Poses [n, 3] [m, m, rad; world frame]."""
        poses: Floats = self.array("the poses", self.call(self.inner.poses, state), (self._n, 3))
        return poses.copy()  # bodies may step in place, and the world still needs the poses of the tick before


class CheckedMetric(Checked):
    """A metric."""

    def add(self, tick: Any) -> None:
        """Add a tick."""
        self.call(self.inner.add, tick)

    def result(self) -> dict[str, float | None]:
        """The numbers up to the last tick."""
        result = self.call(self.inner.result)
        if not isinstance(result, Mapping) or not all(isinstance(name, str) for name in result):
            self.fail(f"result must be a table by name, got {result!r:.60}")
        wrong = [value for value in result.values() if value is not None and not isinstance(value, int | float)]
        if wrong:
            self.fail(f"result must hold numbers, got {wrong[0]!r:.60}")
        return dict(result)


def _shares(checked: Checked, result: Any, shape: tuple[int, ...]) -> Floats:
    """Probabilities, checked."""
    values: Floats = checked.array("the probability", result, shape)
    if values.size and not (values.min() >= 0.0 and values.max() <= 1.0):
        checked.fail(f"the probability must be from 0 to 1, got {values[(values < 0.0) | (values > 1.0)].flat[0]:g}")
    return values


def _text(shape: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, shape))}]"
