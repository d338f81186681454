"""A crew and its state."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from agents.control.clocks import Clocks
from agents.control.links import Links
from agents.control.localization import Localizer, Located
from agents.control.transmitter import Memory, Transmitters
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.extension.protocols import FormationLaw, NeighborRule, SeekingLaw
from fes.model.config import AgentConfig
from fes.model.contacts import Contacts


@dataclass(frozen=True)
class Crew:
    """The constants of a crew during a run."""

    config: AgentConfig
    ids: Ints
    """Robot ids, ascending [n]."""
    rule: NeighborRule
    formation: FormationLaw[Any]
    seeking: SeekingLaw[Any]
    estimates: Callable[[Any, Edges], Floats] | None
    """Estimates of the seeking law without its physical dither; None if it has none."""
    contact_timeout: int
    """Ticks without a beacon after which a peer is no longer known."""
    clocks: Clocks
    transmitters: Transmitters
    localizer: Localizer


class CrewState(NamedTuple):
    """The state that a crew carries from tick to tick."""

    poses: Floats
    """Own poses at the previous tick, as the robots believe [n, 3]."""
    contacts: Contacts
    links: Links
    formation: Any
    """State of the formation law."""
    seeking: Any
    """State of the seeking law."""
    linked_since: Ints
    """Tick of each robot's first link [n]; a large number before."""
    since: Ints
    """Tick of each robot's first step [n]; a large number before."""
    unsent: Memory
    """The contents that late transmitters have not sent yet."""
    located: Located
