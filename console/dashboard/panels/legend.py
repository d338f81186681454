"""The legend: the words and marks on the screen in a few more words."""

from console.dashboard.canvas import Line
from console.dashboard.panels.map_panel import PATH_MARK
from console.measures import reception
from console.terminal.formatting import styled
from fes.protocol.report import Report

LEAST = 3
"""Fewest lines of the panel, with its title."""

_GAP = 2
_WIDE = 48  # cells with room for every word; a narrower legend has only short ones
_LONGEST = 12

Entry = tuple[str, str, str]
"""A word or a mark, and its meaning: short, and in a whole phrase."""

_SOURCES: dict[str, Entry] = {
    "oracle": ("oracle", "index from formula", "each robot computes the index from the channel's formula"),
    "measured": ("measured", "from counted beacons", "each robot fits the index to the beacons that it counts"),
    "sampled": ("sampled", "index from samples", "each beacon gives a robot one sample of the index"),
}
_MAP: tuple[Entry, ...] = (
    ("→ •", "robot and heading", "a robot with its heading, or with an unknown one"),
    ("×", "absent robot", "a robot that takes no part, or whose agent is dead"),
)
_PATH: Entry = (PATH_MARK, "path so far", "the path of a robot so far")
_OPTIMUM: Entry = ("r*", "best separation", "separation with the best index: it trades range against reception")
_TEAM_OPTIMUM: Entry = ("r_β", "best link length", "best link length of the team's shape, in the place of r*")
_ESTIMATES: Entry = ("estimates", "r*, seen by each end", "r* as the robots at both ends of the link estimate it")
_ESTIMATES_OF_ROBOTS: Entry = (
    "estimates",
    "best separation",
    "the best separation, as both ends estimate it",
)
_DISAGREEMENT: Entry = (
    "disagreement",
    "of both ends, summed",
    "difference of both ends' estimates, summed",
)
_ERRORS: tuple[Entry, ...] = (
    ("estimate error", "largest, from r*", "largest distance of an estimate from r*"),
    ("separation error", "largest, from r*", "largest distance of a length from r*, mean over a dither"),
)
_OF_ROBOTS: tuple[Entry, ...] = (
    ("estimate spread", "largest less least", "largest estimate less the smallest one"),
    ("formation error", "length less estimate", "largest distance of a link's length from its estimate"),
    ("lost", "share of beacons", "share of the link's beacons that did not decode"),
    ("heard", "who hears whom", "graph of the robots that hear each other"),
)
_REACHED: Entry = (
    "reached",
    "stays within 1 m",
    "within 1 m of r* for 10 s, or for 5 s after a change",
)
_OUTAGE: Entry = ("outage", "chance of a loss", "true probability that a beacon on this link is lost")
_LEARNT: Entry = ("learnt true", "chance of arrival", "probability that a beacon arrives: as learnt, and true")
_COUNTS: tuple[Entry, ...] = (
    ("decoded", "beacons that arrived", "share of the link's beacons that arrived"),
    ("gap", "most lost in a row", "most beacons of the link that were lost in a row"),
)
_GRAPHS: tuple[Entry, ...] = (
    ("λ₂", "0 if links are cut", "algebraic connectivity: 0 if links do not connect all present"),
    ("disk graph", "all pairs in range", "graph of all pairs of robots in radio range"),
)
_TEAM: tuple[Entry, ...] = (
    ("F", "coverage, delivery", "team index: coverage of the team, and its delivery after a loss"),
    ("cutting", "its loss cuts links", "robots whose loss would cut the links between the others"),
)
_PLANS: tuple[Entry, ...] = (
    ("direct", "straight to its slot", "the robot drives straight to its slot in the shape"),
    ("contracting", "toward the middle", "the robot drives toward the middle, to be heard"),
)


def entries(report: Report, source: str) -> list[Entry]:
    """The entries for what a frame shows, the most important first."""
    is_measured = reception.is_measured(report)
    source = source or ("measured" if is_measured else "")
    cause = [_SOURCES[source]] if source in _SOURCES else []
    if report.is_of_robots:
        return [*cause, _ESTIMATES_OF_ROBOTS, _DISAGREEMENT, *_OF_ROBOTS, *_MAP, _PATH]
    team = [*_TEAM, *(_PLANS if len(report.plans) else ())] if report.has_team_index else []
    optimum = _TEAM_OPTIMUM if len(report.plans) else _OPTIMUM
    link = _LEARNT if is_measured else _OUTAGE
    return [
        optimum,
        *cause,
        _DISAGREEMENT,
        *_ERRORS,
        _ESTIMATES,
        link,
        *_COUNTS,
        *team,
        *_GRAPHS,
        _REACHED,
        *_MAP,
        _PATH,
    ]


def legend(report: Report, source: str, width: int, height: int) -> list[Line]:
    """The entries that fit in `width` x `height`, each with its whole phrase if that fits."""
    shown = [entry for entry in entries(report, source) if width >= _WIDE or len(entry[0]) <= _LONGEST]
    shown = shown[: max(0, height)]
    first = max((len(word) for word, _, _ in shown), default=0) + _GAP
    return [
        [styled(f"{word:<{first}}", "dim"), styled(phrase if first + len(phrase) <= width else short)]
        for word, short, phrase in shown
    ]
