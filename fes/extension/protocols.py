"""The seven kinds of extension, as protocols: any class that has these members is one.

Each class also has `Parameters`, a subclass of `fes.extension.Table`: pydantic rejects unknown keys.

Shapes: n robots, m contacts, l links, q statistics, b bytes, k learnt numbers. A constructor gets (parameters,
context). `parameters` is an instance of the class's own `Parameters`, a pydantic table. State is an ordinary value:
it must pickle, and a method returns a new one instead of changing it.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, TypeVar

from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Bytes, Floats, Ints
from fes.extension.neighborhood import Entry, LinkGeometry, Neighborhood
from fes.model.contacts import Contacts
from fes.model.table import Table

S = TypeVar("S")
"""State of an extension."""


class NoParameters(Table):
    """The parameters of an extension that has none."""


class Formed(NamedTuple):
    """The result of a formation law at one tick."""

    state: Any
    """The state after this tick."""
    pull: Floats
    """Vector from each robot to where it should go [n, 2] [m; world frame]."""
    declared: Bytes | None = None
    """Bytes for the robots' beacons [n, b]; None without any."""
    details: Floats | None = None
    """Numbers for observers [n, j], named by `details` of the class; None without any."""
    twists: Floats | None = None
    """Twists [n, 2] [m/s, rad/s] that replace those that follow from the pull, where they are not NaN."""
    quality_weight: Floats | None = None
    """beta: weight of ln q against ln c in the index that each robot seeks [n] [1]; None: 1."""


class Published(NamedTuple):
    """The values that a seeking law gives peers and observers at one tick."""

    estimates: Floats
    """Estimate of the optimal separation of each link [l] [m]."""
    statistics: Floats
    """Numbers for the robots' beacons [n, q]."""
    learnt: Floats
    """Numbers learnt for each link, for observers [k, l]."""
    declared: Bytes | None = None
    """Bytes for the robots' beacons [n, b]; None without any."""


class NeighborRule(Protocol):
    """Selects neighbors among contacts. A rule may keep a cache: it may change the work, never the result."""

    def __call__(self, contacts: Contacts) -> Bools:
        """True for each contact that its robot selects [m]."""


class FormationLaw(Protocol[S]):
    """Computes where each robot is pulled. The twist of (6), (7) and its limits follow from the pull."""

    @property
    def declared(self) -> int:
        """Number of bytes of its own in each beacon, b."""

    @property
    def details(self) -> tuple[str, ...]:
        """Names of its numbers for observers, j of them."""

    def start(self) -> S:
        """The state before the first tick."""

    def forget(self, state: S, restarted: Bools) -> S:
        """The state in which the robots `restarted` [n] begin anew."""

    def step(self, state: S, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull of each robot at this tick."""


class SeekingLaw(Protocol[S]):
    """Seeks the optimal separation of each link. A tick calls its methods in the order in which they stand here.

    A class with a physical dither may have a static method `physical_period(parameters)`: the period of the
    oscillation of the formation [s], or None. Summaries then average separations over it. It may also have a method
    `estimates(state, links)`: the desired separations without that dither [l] [m].
    """

    @property
    def knows_channel(self) -> bool:
        """True if the law must be told the channel: its context then has it, and the run is not model-free."""

    @property
    def statistics(self) -> int:
        """Number of statistics in each beacon, q."""

    @property
    def declared(self) -> int:
        """Number of bytes of its own in each beacon, b."""

    @property
    def learnt(self) -> tuple[str, ...]:
        """Names of its learnt numbers, k of them."""

    def start(self) -> S:
        """The state before the first tick: no robot has a link."""

    def forget(self, state: S, restarted: Bools, old: Edges, new: Edges) -> S:
        """The state in which the robots `restarted` [n] begin anew; the `new` links are those of the others."""

    def relink(self, state: S, old: Edges, new: Edges, entry: Entry) -> S:
        """The state over the links `new`, from that over `old`. It is called when the set of links changes."""

    def desired(self, state: S, tick: int, links: Edges) -> Floats:
        """The separation to which each link is driven [l] [m]."""

    def measure(self, state: S, around: Neighborhood, formed: Formed) -> S:
        """The state after the beacons of the previous tick, and after the formation law's step."""

    def publish(self, state: S, links: Edges) -> Published:
        """The values for beacons and observers at this tick."""

    def seek(self, state: S, around: Neighborhood) -> S:
        """The state one tick later."""


class Channel(Protocol):
    """The reception probability of the world's radio."""

    def probability(self, separation: Floats) -> Floats:
        """Probability that a beacon decodes at `separation` [m], of the same shape."""


class PairChannel(Protocol):
    """A channel that is known by pair and time, not by separation."""

    def pair_probability(self, time: float, senders: Ints, receivers: Ints, separation: Floats) -> Floats:
        """Probability that a beacon of `time` [s] decodes, for each pair of ids [m]."""


class Dynamics(Protocol[S]):
    """Bodies, and the way in which they follow their commands."""

    def start(self, poses: Floats) -> S:
        """The state of bodies at rest at `poses` [n, 3] [m, m, rad; world frame]."""

    def step(self, state: S, twists: Floats, dt: float) -> S:
        """The state after bodies were told to hold `twists` [n, 2] [m/s, rad/s] for `dt` [s]."""

    def poses(self, state: S) -> Floats:
        """Poses [n, 3] [m, m, rad; world frame]."""


class Metric(Protocol):
    """Named numbers of a run, from the truth of each tick. The object itself is its state, and must pickle.

    A metric reads the attributes of a tick, and imports no class for them. The position of each link among the pairs
    of the radio is `tick.state.radio.edges.find(tick.telemetry.links.keys)`, or -1 if its robots are out of range.
    """

    def add(self, tick: Any) -> None:
        """Add a tick, a `world.metrics.tick_truth.TickTruth`."""

    def result(self) -> Mapping[str, float | None]:
        """The numbers up to the last tick. One that is None, or not finite, is null in the summary."""
