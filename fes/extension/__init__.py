"""The public interface for extensions: laws, neighbor rules, channels, dynamics and metrics. It is stable.

protocols        the protocol of each kind of extension.
controllers      a whole robot in plain Python.
neighborhood     the peers of a robot at one tick, as its laws see them.
context          the second argument of a constructor, beside its parameters.
conformance      for pytest: a check that an extension keeps the rules.
kinds            the kinds of extension, and the built-in ones.
registry         extensions by name.
crew_laws        the laws of a crew, the robots of one process.
told_channel     the channel, for a law that is told it.
controller_laws  the laws of a crew of controllers.
checked          checks of the values that an extension returns.
evidence         the code of an extension: distribution, version and SHA-256.
"""

from fes.arithmetic import elementary, sums
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Bytes, Floats, Ints
from fes.extension.context import LawContext, WorldContext
from fes.extension.controllers import Action, ControllerContext, Neighbor, Pull, RobotView, Twist
from fes.extension.neighborhood import Entry, LinkGeometry, Neighborhood
from fes.extension.protocols import Formed, NoParameters, Published
from fes.model.contacts import Contacts
from fes.model.objective import preference
from fes.model.table import NonNegative, Positive, Table

__all__ = [
    "API",
    "Action",
    "Bools",
    "Bytes",
    "Contacts",
    "ControllerContext",
    "Edges",
    "Entry",
    "Floats",
    "Formed",
    "Ints",
    "LawContext",
    "LinkGeometry",
    "Neighbor",
    "Neighborhood",
    "NoParameters",
    "NonNegative",
    "Positive",
    "Published",
    "Pull",
    "RobotView",
    "Table",
    "Twist",
    "WorldContext",
    "elementary",
    "preference",
    "sums",
]

API = 1
"""Version of this interface: it rises when an extension must change."""
