"""The summary of a run and its directory: what scripts outside the project read."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from fes.arrays import Floats
from fes.edges import Edges
from world import graphs, metrics
from world.metrics import Tally
from world.scenario import Scenario
from world.simulation import State


def summarize(
    scenario: Scenario,
    name: str,
    backend: str,
    tally: Tally,
    final: State,
    links: Edges,
    estimates: Floats,
    wall: float,
) -> dict[str, Any]:
    """The summary of a run; `final` is its last tick, `links` and `estimates` what the robots used at it."""
    n, optimal = scenario.robots.number, tally.optimal
    a, b = metrics.ends(links)
    separation = metrics.separations(final.poses, a, b)
    edges = _edges(links, separation, estimates)
    simulated = tally.ticks * scenario.run.dt
    return {
        "scenario": name,
        "seed": scenario.run.seed,
        "backend": backend,
        "clock": scenario.run.clock,
        "robots": n,
        "ticks": tally.ticks,
        "dt": scenario.run.dt,
        "simulated_s": simulated,
        "wall_s": wall,
        "ticks_per_s": tally.ticks / wall if wall > 0 else None,
        "real_time_factor": simulated / wall if wall > 0 else None,
        "optimal_separation": optimal,
        "edges": edges,
        "separation_error_max": _largest(separation - optimal),
        "separation_error_rms": _rms(separation - optimal),
        "disagreement": None if len(links) == 0 else tally.errors["disagreement"],
        "estimate_error_max": _largest(estimates - optimal),
        "estimate_error_rms": _rms(estimates - optimal),
        "disk_connected_always": tally.disk_always,
        "links_connected_always": tally.links_always,
        "algebraic_connectivity": graphs.algebraic_connectivity(n, a, b),
        "beacons_sent": final.sent,
        "beacons_decoded": final.decoded,
        "time_to": tally.times(),
        "digest": tally.digest(),
    }


def write(directory: Path, summary: dict[str, Any]) -> None:
    """Write summary.json: complete or not at all."""
    temporary = directory / ".summary.json"
    temporary.write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, directory / "summary.json")


def write_scenario(directory: Path, scenario: Scenario) -> None:
    """Write scenario.toml: the scenario as it is run, with every default and override."""
    tables = scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
    (directory / "scenario.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")


def _edges(links: Edges, separation: Floats, estimates: Floats) -> list[list[float | int | None]]:
    """[i, j, separation, estimate of i, estimate of j] for each link, i < j; None where one side has no link."""
    rows = []
    for at, length in zip(links.undirected.tolist(), separation.tolist(), strict=True):
        i, j, other = int(links.rows[at]), int(links.peers[at]), int(links.reverse[at])
        mine, theirs = float(estimates[at]), float(estimates[other]) if other >= 0 else None
        rows.append([i, j, length, mine, theirs] if i < j else [j, i, length, theirs, mine])
    return sorted(rows, key=lambda row: row[:2])


def _largest(errors: Floats) -> float | None:
    return float(np.abs(errors).max()) if len(errors) else None


def _rms(errors: Floats) -> float | None:
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else None
