"""Summaries and digests, compared and computed again."""

import hashlib
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from console.backends import inprocess
from console.sweep import work
from fes.arrays.types import Floats
from world.config.scenario import Scenario
from world.metrics import summary


def written(directory: Path, result: dict[str, Any]) -> Any:
    """The summary in the run directory, by a strict JSON reader."""
    summary.write(directory, result)

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    return json.loads((directory / "summary.json").read_text(encoding="utf-8"), parse_constant=refuse)


def without_wall_clock(summary: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in summary.items() if name not in work.WALL_CLOCK}


def alone(scenarios: list[Scenario]) -> list[dict[str, Any]]:
    return [without_wall_clock(inprocess.run(scenario, "x")) for scenario in scenarios]


Tick = tuple[Floats, Floats]
"""Poses [n, 3] and twists [n, 2]."""


def contract_digest(ticks: Sequence[Tick]) -> str:
    """SHA-256 of each tick as int64, then x, y, heading, linear, angular of each robot as float64."""
    text = hashlib.sha256()
    for number, (poses, twists) in enumerate(ticks):
        text.update(struct.pack("<q", number))
        for pose, twist in zip(poses.tolist(), twists.tolist(), strict=True):
            text.update(struct.pack("<5d", *pose, *twist))
    return text.hexdigest()
