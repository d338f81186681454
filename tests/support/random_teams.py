"""Random inputs and states of a crew: peers that come and go, ties, coinciding robots, and numbers of all kinds."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from agents.control import contacts, links
from agents.control import crew as crews
from agents.control.state import Crew, CrewState
from agents.laws import packet_counting
from agents.laws.packet_counting import ReceptionFit
from agents.laws.seeking_measured import Measured
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.extension.neighborhood import Neighborhood
from fes.model.contacts import Contacts
from fes.model.sensing import Beacons, Observations, Received
from tests.support import bits, loop
from world.config.scenario import agent_config


class Size(NamedTuple):
    """The amount of everything."""

    robots: int
    peers: int
    """Largest number of peers in range."""
    rounds: int


@dataclass(frozen=True, eq=False)
class Round:
    """One tick by numpy: the inputs of the crew, and what its kernels take and give."""

    observations: Observations
    beacons: Beacons
    received: Received
    before: CrewState
    since: Ints
    """Tick of each robot's first step [n]."""
    known: Contacts
    selected: Any
    """Contacts that the neighbor rule selects [m]."""
    relinked: CrewState
    """The state with its new links, before its seeking law has moved."""
    around: Neighborhood


def crew_of(name: str, robots: int, seed: int = 0, **overrides: Any) -> Crew:
    """A crew of some of twice as many robots, with the laws of a scenario."""
    scenario = loop.load(f"{name}.toml", **overrides)
    ids = np.sort(np.random.default_rng(seed).permutation(2 * robots)[:robots])
    return crews.create(agent_config(scenario), ids)


def rounds(crew: Crew, size: Size, seed: int, strange: float = 0.0) -> Iterator[Round]:
    """Ticks in a row of a crew; a share `strange` of the numbers are special ones."""
    generator = np.random.default_rng(seed)
    everybody, receiver = np.arange(2 * len(crew.ids)), Receiver()
    tick, state = int(generator.integers(1, 2000)), crews.start(crew)
    in_range = _edges(generator, crew.ids, everybody, size.peers)
    for _ in range(size.rounds):
        tick += 1
        if generator.random() < 0.5:
            in_range = _edges(generator, crew.ids, everybody, size.peers)
        reception = generator.integers(0, 3, len(in_range)).astype(np.uint8)
        poses = bits.sprinkled(generator, _poses(generator, len(crew.ids)), 0.1 * strange)
        observations = Observations(tick, poses, in_range, reception)
        beacons = _beacons(generator, tick - 1, everybody, crew.seeking.statistics, size.peers, strange)
        before = _disturbed(generator, crew, state, tick, strange)
        done = by_numpy(crew, receiver, observations, beacons, before)
        yield done
        seeking = crew.seeking.seek(done.relinked.seeking, done.around)
        state = done.relinked._replace(poses=poses, seeking=seeking)


def by_numpy(crew: Crew, receiver: Receiver, observations: Observations, beacons: Beacons, state: CrewState) -> Round:
    """The first half of a tick, in the order of `agents.control.crew.step`."""
    tick, since = observations.tick, np.minimum(state.since, observations.tick)
    received = receiver.receive(observations, beacons, state.contacts.edges)
    known = contacts.update(state.contacts, received, state.poses, crew.contact_timeout)
    selected = crew.rule(known)
    used = links.among(state.links, state.contacts, known, selected | (known.selected_by_peer & known.known))
    linked_since, seeking = crews._relink(crew, state, used, tick, since, received)
    poses, config = observations.poses, crew.config
    relinked = CrewState(poses, known, used, None, seeking, linked_since, since, {}, state.located)
    around = Neighborhood(tick, config.dt, poses, known, state.contacts, used.edges, used.contact)
    return Round(observations, beacons, received, state, since, known, selected, relinked, around)


def _poses(generator: np.random.Generator, count: int) -> Floats:
    """Poses [n, 3] of which many coincide or are equally far apart."""
    poses = generator.uniform(-200.0, 200.0, (count, 3))
    poses[:, 2] = generator.uniform(-20.0, 20.0, count)
    is_regular = generator.random(count) < 0.5
    poses[is_regular, :2] = 30.0 * np.round(poses[is_regular, :2] / 60.0)
    return poses


def _edges(generator: np.random.Generator, ids: Ints, everybody: Ints, most: int) -> Edges:
    """Some peers of each robot: none for some of them."""
    lists = []
    for robot in ids.tolist():
        count = int(generator.integers(0, most + 1))
        chosen = np.sort(generator.permutation(everybody)[:count])
        lists.append(chosen[chosen != robot])
    return Edges(ids, np.repeat(np.arange(len(ids)), [len(peers) for peers in lists]), np.concatenate(lists))


def _beacons(
    generator: np.random.Generator, tick: int, everybody: Ints, statistics: int, most: int, strange: float
) -> Beacons:
    """Beacons of most robots; some of them have no links."""
    kind = generator.random()
    senders = everybody if kind < 0.3 else everybody[generator.random(len(everybody)) < 0.8]
    if kind > 0.95:
        senders = senders[:0]
    edges = _edges(generator, senders, everybody, most) if len(senders) else links.no_links(senders).edges
    # other laws send other numbers of statistics
    count = statistics if generator.random() < 0.9 else 3
    numbers = generator.uniform(-1.0, 3.0, (len(senders), count))
    estimates = generator.choice([np.nan, 70.0, -5.0], len(edges))
    estimates = np.where(generator.random(len(edges)) < 0.9, generator.uniform(20.0, 140.0, len(edges)), estimates)
    return Beacons(
        tick,
        senders,
        bits.sprinkled(generator, _poses(generator, len(senders)), strange),
        edges,
        bits.sprinkled(generator, estimates, strange),
        generator.random(len(edges)) < 0.3,
        bits.sprinkled(generator, numbers, strange),
        np.zeros((len(senders), 0), np.uint8),
    )


def _disturbed(generator: np.random.Generator, crew: Crew, state: CrewState, tick: int, strange: float) -> CrewState:
    """The state with other numbers, but the same contacts and links."""
    n, m, count = len(crew.ids), len(state.contacts.edges), len(state.links.edges)
    is_linked = state.links.edges.counts > 0
    never = np.iinfo(np.int64).max // 2
    since = np.where(generator.random(n) < 0.3, generator.choice([0, 1, tick - 1, tick, never], n), state.since)
    linked_since = np.where(is_linked, tick - generator.integers(1, 6, n), never)
    heard = np.where(generator.random(m) < 0.2, tick - generator.integers(2, 80, m), state.contacts.heard)
    changed: dict[str, Any] = {"heard": heard}
    for name in ("x", "y", "heading", "estimates", "heard_separation"):
        changed[name] = bits.sprinkled(generator, getattr(state.contacts, name), strange)
    known = state.contacts._replace(**changed)
    poses = bits.sprinkled(generator, _poses(generator, n), 0.1 * strange)
    seeking, estimates = state.seeking, bits.sprinkled(generator, generator.uniform(20.0, 140.0, count), strange)
    if isinstance(seeking, Measured):
        old = seeking.fit
        statistics = generator.uniform(-0.5, 5.0, old.statistics.shape)
        fit = ReceptionFit(old.method, bits.sprinkled(generator, statistics, strange), old.level, old.exponent)
        nobody = np.zeros(len(statistics), np.bool_)
        seeking = Measured(estimates, seeking.ahead, packet_counting.forget(fit, nobody))
    else:
        others = bits.sprinkled(generator, generator.choice([0.0, -0.0, -0.5, 3.0, 1e4], (2, count)), strange)
        seeking = np.stack([estimates, *others])
    return state._replace(poses=poses, contacts=known, seeking=seeking, since=since, linked_since=linked_since)
