"""The kinds of runs in the study of safe separation: teams of random layouts, by configuration."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from agents.control.state import Crew
from fes.arrays.types import Floats, Ints
from fes.extension import registry
from fes.extension.context import LawContext, SeededDraws
from tests.support import drivers
from tests.support.adversaries import PATROL, PURSUE, SQUEEZE, THRASH, Adversary
from tests.support.passing_runs import LONGEST, Batch, Team, placed

Rng = np.random.Generator

APART = 10.0
"""Least distance of two starts, and of two goals [m]: twice the safe separation."""

BURSTS = {"bursts": {"bad_share": 0.2, "mean_length": 0.5, "loss": 1.0}}

ORACLE = {"index": "oracle", "initial_estimate": [50.0, 90.0], "index_transform": "log", "index_gain": 40000.0}
"""As in configs/neighborhood.toml."""

COUNTS = {
    "circle of 2": 60,
    "circle of 6": 80,
    "circle of 10": 60,
    "box of 100 m, 10": 100,
    "box of 250 m, 20": 40,
    "box of 120 m, 20": 40,
    "lanes, 5 m/s": 80,
    "lanes, 2 m/s": 40,
    "lanes, 10 m/s": 40,
    "lanes, 20 m/s": 40,
    "march through a crowd": 40,
    "one stands still": 40,
    "pursuit": 60,
    "squeeze": 40,
    "random pulls": 40,
    "bursts, timeout 5 s": 60,
    "bursts, timeout 1 s": 40,
    "clocks off": 40,
    "one dies": 20,
    "one sends old places": 20,
    "controllers": 20,
}
"""Kind -> number of runs of the whole study."""


def poses(rng: Rng, places: Floats) -> Floats:
    """Any headings at `places` [n, 2]."""
    return np.column_stack([places, rng.uniform(-math.pi, math.pi, len(places))])


def on_circle(n: int, radius: float) -> Floats:
    angles = 2.0 * math.pi * np.arange(n) / n
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def circle(rng: Rng, kind: str, n: int) -> Team:
    """n robots that change places with the opposite ones."""
    places = on_circle(n, max(60.0, 8.0 * n))
    return Team(kind, poses(rng, places), -places, {})


def frozen(rng: Rng, kind: str) -> Team:
    """A circle of six, and a robot in its center that stands still and is heard."""
    around = circle(rng, kind, 6)
    center = np.array([[*rng.uniform(-3.0, 3.0, 2), 0.0]])
    return around._replace(
        starts=np.concatenate([around.starts, center]), goals=np.concatenate([around.goals, center[:, :2]])
    )


def dead(rng: Rng, kind: str) -> Team:
    """A circle of six, of which one dies near the center: its body remains, and its radio is silent."""
    return circle(rng, kind, 6)._replace(event={"at": round(rng.uniform(8.0, 14.0), 2), "kill": [0]})


def late(rng: Rng, kind: str) -> Team:
    """A circle of six, of which one sends its place of half a second ago."""
    return circle(rng, kind, 6)._replace(event={"at": 0.0, "transmitter": {"robot": 0, "delay": 0.5}})


def scattered(rng: Rng, n: int, width: float, apart: float = APART) -> Floats:
    """n places in a square [n, 2]."""
    places = np.zeros((0, 2))
    while len(places) < n:
        place = rng.uniform(-0.5 * width, 0.5 * width, 2)
        if (np.hypot(*(places - place).T) >= apart).all():
            places = np.concatenate([places, place[None]])
    return places


def box(rng: Rng, kind: str, n: int, width: float) -> Team:
    """n robots in a square, with goals in it."""
    return Team(kind, poses(rng, scattered(rng, n, width)), scattered(rng, n, width), {})


def lanes(rng: Rng, kind: str, longest: float) -> Team:
    """Two robots side by side that change sides over a long way."""
    gap, length, turn = rng.uniform(6.0, 12.0), rng.uniform(0.25, 1.0) * longest, rng.uniform(-0.1, 0.1, 2)
    starts = np.array([[0.0, 0.0, 0.5 * math.pi + turn[0]], [gap, 0.0, 0.5 * math.pi + turn[1]]])
    return Team(kind, starts, np.array([[gap, length], [0.0, length]]), {})


def march(rng: Rng, kind: str) -> Team:
    """Four robots in a row that drive through a crowd of eight standing ones."""
    crowd = scattered(rng, 8, 80.0, 16.0)
    row = np.stack([np.full(4, -60.0), 15.0 * np.arange(4) - 22.5], axis=1)
    starts = np.concatenate([poses(rng, row), poses(rng, crowd)])
    return Team(kind, starts, np.concatenate([-row, crowd]), {})


def crowd(rng: Rng, kind: str) -> Team:
    """Ten robots so close that the filter acts while the paper's law spreads them."""
    places = scattered(rng, 10, 25.0, 5.5)
    return Team(kind, poses(rng, places), np.full((10, 2), math.nan), {})


def blocking(rng: Rng, kind: str) -> Team:
    """Two robots face to face that change places."""
    places = np.array([[-rng.uniform(20.0, 60.0), 0.0], [rng.uniform(20.0, 60.0), 0.0]])
    return Team(kind, np.column_stack([places, [0.0, math.pi]]), places[::-1].copy(), {})


def attack(rng: Rng, kind: str, n: int) -> Team:
    """n robots in a square; the roles of `adversaries` use the goals, and no robot arrives."""
    width = 20.0 * math.sqrt(n)
    goals = scattered(rng, n, width) if kind == "pursuit" else np.zeros((n, 2))
    return Team(kind, poses(rng, scattered(rng, n, width)), goals, {})


def adversaries(teams: list[Team], longest: float) -> Batch:
    """Teams with a role for each robot, by their kind: half of a pursuit pursues the others."""
    roles = np.concatenate([_roles(team) for team in teams])

    def wrap(crew: Crew, goals: Floats) -> Crew:
        config = crew.config
        context = LawContext(crew.ids, config.dt, config.objective, SeededDraws(config.seed), lambda *_: np.zeros(1))
        return replace(crew, formation=Adversary(roles, goals, context))

    return Batch(teams, longest=longest, wrap=wrap)


def _roles(team: Team) -> Ints:
    """The role of each robot [n]."""
    ids = np.arange(len(team.starts))
    if team.kind == "pursuit":
        return np.where(ids < len(ids) // 2, PURSUE, PATROL)
    return np.full(len(ids), SQUEEZE if team.kind == "squeeze" else THRASH)


def batches(counts: Mapping[str, int], seed: int, longest: float = LONGEST) -> list[Batch]:
    """The runs of some kinds, as few batches; runs in which no robot arrives last `longest` [s]."""
    rng = np.random.default_rng(seed)

    def some(kind: str, make: Callable[..., Team], *arguments: float) -> list[Team]:
        return [make(rng, kind, *arguments) for _ in range(counts.get(kind, 0))]

    usual = [
        *(team for n in (2, 6, 10) for team in some(f"circle of {n}", circle, n)),
        *some("box of 100 m, 10", box, 10, 100.0),
        *some("box of 250 m, 20", box, 20, 250.0),
        *some("box of 120 m, 20", box, 20, 120.0),
        *some("lanes, 5 m/s", lanes, 400.0),
        *some("march through a crowd", march),
        *some("one stands still", frozen),
        *some("one dies", dead),
        *some("one sends old places", late),
    ]
    attackers = [
        *(attack(rng, "pursuit", (2, 4, 8)[run % 3]) for run in range(counts.get("pursuit", 0))),
        *some("squeeze", attack, 8),
        *some("random pulls", attack, 8),
    ]
    lossy = {kind: [*some(kind, circle, 6), *some(kind, box, 10, 100.0)][::2] for kind in counts if "bursts" in kind}
    dense = some("clocks off", crowd)
    blocked = some("controllers", blocking)
    all_batches = [
        Batch(usual),
        Batch(some("lanes, 2 m/s", lanes, 200.0), {"linear_limit": 2.0, "separation_gain": 0.4}),
        Batch(some("lanes, 10 m/s", lanes, 400.0), {"linear_limit": 10.0}),
        Batch(some("lanes, 20 m/s", lanes, 400.0), {"linear_limit": 20.0}),
        adversaries(attackers, longest) if attackers else Batch([]),
        *(
            Batch(teams, {"contact_timeout": float(kind.split()[-2])}, {"channel": BURSTS})
            for kind, teams in lossy.items()
        ),
        Batch(dense, {"law": "paper"}, {"seeking": ORACLE}, min(longest, 60.0), clock_skew=1.0),
        controlled(blocked) if blocked else Batch([]),
    ]
    return [batch for batch in all_batches if batch.teams]


def controlled(teams: list[Team]) -> Batch:
    """Teams whose controllers command twists."""
    batch = Batch(teams, longest=60.0)
    registry.use(drivers.__name__)
    parameters = {"use": f"{drivers.__name__}:Driver", "goals": placed(batch)[1].tolist()}
    return replace(batch, tables={"robots": {"poses": placed(batch)[0].tolist(), "controller": parameters}})
