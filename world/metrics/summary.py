"""The summary of a run, and summary.json and scenario.toml, which scripts outside the project read."""

import contextlib
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from fes.arithmetic import sums
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.errors import FesError, reason
from fes.model import quantities
from fes.system import fingerprint, strict_json
from world.config import expectations
from world.config.scenario import Scenario
from world.metrics import graphs, link_errors
from world.metrics.collector import MetricsCollector
from world.simulation.channel import Radio

ROBOTS = "robots"
"""Clock in the summary of a run of real robots; a world's is `lockstep` or `live`."""


@np.errstate(over="ignore", invalid="ignore")
def summarize(metrics: MetricsCollector, name: str, backend: str, wall: float) -> dict[str, Any]:
    """The summary of a run up to the last tick of `metrics`; `wall` is its wall-clock time [s].

    `fes.model.quantities` describes its values; a number that is missing or not finite is None.
    """
    scenario, errors, optimal = metrics.scenario, metrics.link_errors, metrics.optimal
    n, links, estimates = scenario.robots.number, metrics.telemetry.links, metrics.telemetry.estimates
    separation = metrics.separation
    simulated = errors.ticks * scenario.run.dt
    values = {
        **metrics.shared(),
        "scenario": name,
        "seed": scenario.run.seed,
        "backend": backend,
        "clock": scenario.run.clock,
        "robots": n,
        "ticks": errors.ticks,
        "dt": scenario.run.dt,
        "simulated_s": simulated,
        "wall_s": wall,
        "ticks_per_s": errors.ticks / wall if wall > 0 else None,
        "real_time_factor": simulated / wall if wall > 0 else None,
        "edges": _edges(links, separation, estimates),
        "separation_error_max": _largest(separation - optimal),
        "separation_error_rms": _rms(separation - optimal),
        "estimate_error_rms": _rms(estimates - optimal),
        "disk_connected_always": errors.disk_always,
        "links_connected_always": errors.links_always,
        "algebraic_connectivity": graphs.algebraic_connectivity(n, *link_errors.ends(links)),
        "time_to": errors.times(),
        "digest": errors.digest.text(),
        "tracking": metrics.tracking.table(),
        "radio": _contacts(metrics.state.radio),
        "deadlines": None if metrics.deadlines is None else metrics.deadlines.table(),
        "arithmetic": fingerprint.table(),
        "links_gap_longest": errors.longest_gap * scenario.run.dt,
        "unscheduled_absences": metrics.unscheduled_absences,
        "links_lost_at": errors.links_lost_at,
        "smallest_separation": metrics.smallest_separation,
        "model_free": metrics.is_model_free,
        "metrics": metrics.team_numbers(),
    }
    if metrics.team is not None:
        values |= metrics.team.table(metrics.state, metrics.telemetry)
    values[quantities.VERDICTS] = expectations.verdicts(scenario.expect, values)
    summary: dict[str, Any] = strict_json.finite(quantities.ordered(values))
    return summary


def clear(directory: Path) -> None:
    """Delete the summary of an older run from a run directory."""
    (directory / "summary.json").unlink(missing_ok=True)


def write(directory: Path, summary: dict[str, Any]) -> None:
    """Write summary.json, completely or not at all; raises FesError."""
    _write(directory / "summary.json", strict_json.dumps(summary, indent=1) + "\n")


def lines(summary: dict[str, Any]) -> list[str]:
    """The summary in a few lines of a log."""
    links, time = len(summary["edges"]), f"{summary['simulated_s']:g} s in {summary['wall_s']:.1f} s"
    lost_at = summary["links_lost_at"]
    text = [
        f"{summary['scenario']}, {summary['robots']} robots, seed {summary['seed']}: {time}",
        f"{links} links, r* = {_meters(summary['optimal_separation'], 3)}",
    ]
    if links:
        errors = (
            (error.replace("_", " "), summary[f"{error}_max"]) for error in ("separation_error", "estimate_error")
        )
        text += [f"largest {error}: {_meters(largest, 4)}" for error, largest in errors]
    if lost_at is not None:
        text.append(links_lost(lost_at))
    since = summary["time_to"]["separation_0_1m"]
    text.append("separation error < 0.1 m: " + ("not reached" if since is None else f"reached at {since:.2f} s"))
    return [*text, f"digest {summary['digest']}"]


def links_lost(since: float) -> str:
    """One line about a team without links since a time [s]."""
    if since == 0.0:
        return "no robot ever had a link"
    return f"all links were lost permanently at {since:g} s: no robot has had one since"


def _meters(value: float | None, digits: int) -> str:
    return "unknown" if value is None else f"{value:.{digits}f} m"


def write_scenario(directory: Path, scenario: Scenario) -> None:
    """Write scenario.toml, completely or not at all: the scenario with every default and override.

    Raises FesError.
    """
    tables = scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
    _write(directory / "scenario.toml", tomli_w.dumps(tables))


def _write(path: Path, text: str) -> None:
    """Write a file, completely or not at all; raises FesError, which names the file."""
    temporary = path.with_name(f".{path.name}")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None


def _edges(links: Edges, separation: Floats, estimates: Floats) -> list[list[float | int | None]]:
    """[i, j, separation, estimate of i, estimate of j] per link, i < j; None for a robot that does not use it."""
    rows = []
    for position, length in zip(links.undirected.tolist(), separation.tolist(), strict=True):
        i, j, back = int(links.rows[position]), int(links.peers[position]), int(links.reverse[position])
        own, peers = float(estimates[position]), float(estimates[back]) if back >= 0 else None
        rows.append([i, j, length, own, peers] if i < j else [j, i, length, peers, own])
    return sorted(rows, key=lambda row: row[:2])


def _contacts(radio: Radio) -> list[list[float | int]]:
    """[receiver, sender, sent, decoded, mean true outage, longest gap] per contact, since it opened."""
    edges = radio.edges
    used = np.flatnonzero(radio.sent > 0)
    mean = radio.outage_sum[used] / radio.sent[used]
    columns = (
        edges.ids[edges.rows[used]],
        edges.peers[used],
        radio.sent[used],
        radio.decoded[used],
        mean,
        radio.longest_gap[used],
    )
    return [list(row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def _largest(errors: Floats) -> float | None:
    return float(np.abs(errors).max()) if len(errors) else None


def _rms(errors: Floats) -> float | None:
    return math.sqrt(sums.mean(np.square(errors))) if len(errors) else None
