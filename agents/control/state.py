"""A crew and its state."""

from dataclasses import dataclass

from agents.control.clocks import Clocks
from agents.control.links import Links
from agents.control.transmitter import Memory, Transmitters
from agents.laws.draws import Draws
from agents.laws.neighbor_rules import Witnesses
from agents.laws.packet_counting import ReceptionFit
from agents.laws.perturbation import Seeker
from fes.arrays.types import Floats, Ints
from fes.model.config import AgentConfig
from fes.model.contacts import Contacts


@dataclass(frozen=True)
class Crew:
    """The constants of a crew during a run."""

    config: AgentConfig
    ids: Ints
    """Robot ids, ascending [n]."""
    draws: Draws
    seeker: Seeker
    contact_timeout: int
    """Ticks without a beacon after which a peer is no longer known."""
    statistics: int
    """Number of statistics in a beacon; 0 if robots do not pool any."""
    clocks: Clocks
    transmitters: Transmitters


@dataclass(frozen=True, eq=False)
class CrewState:
    """The state that a crew carries from tick to tick."""

    poses: Floats
    """Own poses at the previous tick [n, 3]."""
    contacts: Contacts
    witnesses: Witnesses
    links: Links
    reception: ReceptionFit
    linked_since: Ints
    """Tick of each robot's first link [n]; a large number before."""
    since: Ints
    """Tick of each robot's first step [n]; a large number before."""
    unsent: Memory
    """The contents that late transmitters have not sent yet."""
