"""The buffer of a crew's state: the place of each of its arrays, and conversion from and to `CrewState`."""

import ctypes
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.control import localization
from agents.control.links import Links
from agents.control.state import Crew, CrewState
from agents.core.constants import ALONE, POOLED, CrewConstants
from agents.laws import packet_counting
from agents.laws.packet_counting import ReceptionFit
from agents.laws.seeking_measured import Measured
from fes.arithmetic.core.library import Buffer
from fes.arrays.edges import Edges
from fes.arrays.types import Ints
from fes.model.contacts import Contacts

Array = NDArray[Any]

_FIELDS: dict[str, type] = {
    "poses": np.float64,
    "linked_since": np.int64,
    "since": np.int64,
    "contact_begin": np.int64,
    "contact_peers": np.int64,
    "heard": np.int64,
    "x": np.float64,
    "y": np.float64,
    "heading": np.float64,
    "estimates": np.float64,
    "heard_separation": np.float64,
    "dx": np.float64,
    "dy": np.float64,
    "separation": np.float64,
    "statistics": np.float64,
    "selected_by_peer": np.bool_,
    "known": np.bool_,
    "is_link": np.bool_,
    "link_begin": np.int64,
    "link_rows": np.int64,
    "link_peers": np.int64,
    "contact": np.int64,
    "seeking": np.float64,
    "ahead": np.float64,
    "fit": np.float64,
    "level": np.float64,
    "exponent": np.float64,
    "twists": np.float64,
    "sent_poses": np.float64,
    "sent_statistics": np.float64,
    "selected": np.bool_,
    "sent": np.float64,
    "learnt": np.float64,
}
"""The arrays of a state, in the order of fes_crew_layout, and their types."""


class Layout:
    """The places of the arrays in a buffer of `capacity` contacts, and as many links."""

    def __init__(self, library: ctypes.CDLL, constants: CrewConstants, capacity: int) -> None:
        places = (ctypes.c_int64 * len(_FIELDS))()
        self.capacity = capacity
        length: int = library.fes_crew_layout(ctypes.addressof(constants.constants), capacity, places)
        self.buffer = ctypes.c_char * length
        """Class of a buffer, of zeros: its address is known, and numpy arrays can lie in it."""
        self.places = dict(zip(_FIELDS, places, strict=True))
        """Place of each array [bytes]."""

    def view(self, buffer: Buffer, name: str, shape: int | tuple[int, ...]) -> Array:
        """The first numbers of one array of a buffer, as an array of this shape."""
        return np.ndarray(shape, _FIELDS[name], buffer, self.places[name])


class Stored(NamedTuple):
    """A state in a buffer."""

    buffer: Buffer
    layout: Layout

    @property
    def address(self) -> int:
        """The address of the buffer."""
        return ctypes.addressof(self.buffer)


def unpacked(stored: Stored, crew: Crew, constants: CrewConstants) -> CrewState:
    """The state of a buffer as the numpy code has it."""
    buffer, layout = stored
    n, q, kind = len(crew.ids), constants.constants.statistics, constants.constants.seeking

    def view(name: str, *shape: int) -> Array:
        return layout.view(buffer, name, shape).copy()

    begins, link_begins = view("contact_begin", n + 1), view("link_begin", n + 1)
    m, links = int(begins[n]), int(link_begins[n])
    edges = Edges(crew.ids, np.repeat(np.arange(n), begins[1:] - begins[:-1]), view("contact_peers", m))
    names = (name for name in Contacts._fields if name not in ("edges", "statistics", "declared"))
    columns = {name: view(name, m) for name in names}
    contacts = Contacts(edges, **columns, statistics=view("statistics", m, q), declared=np.zeros((m, 0), np.uint8))
    of_links = Edges(crew.ids, view("link_rows", links), view("link_peers", links))
    used = Links(view("is_link", m), view("contact", links), of_links)
    seeking: Any
    if kind in (POOLED, ALONE):
        learners = n if kind == POOLED else links
        method = crew.seeking.start().fit.method
        fit = ReceptionFit(method, view("fit", learners, 5), view("level", learners), view("exponent", learners))
        ahead = view("ahead", links) if kind == ALONE else np.zeros(links)
        seeking = Measured(view("seeking", links), ahead, fit)
    else:
        seeking = view("seeking", 3, layout.capacity)[:, :links].copy()
    poses, since = view("poses", n, 3), view("since", n)
    located = localization.start(n)  # `agents.runtime.crew_run` has it
    return CrewState(poses, contacts, used, None, seeking, view("linked_since", n), since, {}, located)


def packed(state: CrewState, layout: Layout) -> Stored:
    """The state in a new buffer of a layout with room for its contacts."""
    buffer = layout.buffer()

    def put(name: str, values: Array) -> None:
        layout.view(buffer, name, values.shape)[...] = values

    contacts, links, seeking = state.contacts, state.links, state.seeking
    put("poses", state.poses)
    put("linked_since", state.linked_since)
    put("since", state.since)
    put("contact_begin", contacts.edges.begins)
    put("contact_peers", contacts.edges.peers)
    for name in ("heard", "x", "y", "heading", "estimates", "heard_separation", "dx", "dy", "separation"):
        put(name, getattr(contacts, name))
    for name in ("statistics", "selected_by_peer", "known"):
        put(name, getattr(contacts, name))
    put("is_link", links.is_link)
    put("link_begin", links.edges.begins)
    put("link_rows", links.edges.rows)
    put("link_peers", links.edges.peers)
    put("contact", links.contact)
    if isinstance(seeking, Measured):
        put("seeking", seeking.estimates)
        if seeking.fit.method is packet_counting.ALONE:
            put("ahead", seeking.ahead)
        put("fit", seeking.fit.statistics)
        put("level", seeking.fit.level)
        put("exponent", seeking.fit.exponent)
    else:
        layout.view(buffer, "seeking", (3, layout.capacity))[:, : seeking.shape[1]] = seeking
    return Stored(buffer, layout)


def link_edges(ids: Ints, stored: Stored, count: int) -> Edges:
    """The links of a buffer."""
    rows: Ints = stored.layout.view(stored.buffer, "link_rows", count).copy()
    peers: Ints = stored.layout.view(stored.buffer, "link_peers", count).copy()
    return Edges(ids, rows, peers)
