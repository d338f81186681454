"""The public interface for laws, rules, channels, bodies and metrics of others: the one stable Python API.

protocols        what an extension implements, one protocol per kind.
controllers      a whole robot in plain Python.
neighborhood     what a robot's laws know of its peers at one tick.
context          what a constructor gets beside its parameters.
conformance      for pytest: whether an extension keeps the rules.
kinds            the kinds of extension, and the built-in ones.
registry         extensions by name.
crew_laws        the laws of a crew.
told_channel     the channel, for a law that is told it.
controller_laws  the laws of a crew of controllers.
checked          what an extension returns, checked.
evidence         which code an extension was.
"""

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
    "preference",
]

API = 1
"""Version of this interface: it rises when an extension must change."""
