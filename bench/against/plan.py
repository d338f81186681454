"""The circumstances of a table, and what a row is."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bench.against.cores import Core
from bench.against.table import Line, Wanted


@dataclass(frozen=True)
class Plan:
    """The circumstances of a table."""

    rounds: int
    """Rounds of each row."""
    seeds: int
    """Seeds of the sweep."""
    is_short: bool
    """True for a quick look: shorter runs."""
    folder: Path
    """Folder of the environments."""
    cores: list[Core]
    """The cores with which fes runs."""

    def pick(self, full: float, short: float) -> float:
        """A length of runs."""
        return short if self.is_short else full


@dataclass(frozen=True)
class Row:
    """One row of the table for each core, or several that are measured together."""

    name: str
    groups: tuple[str, ...]
    """Other words that choose it."""
    what: str
    """The comparison, and its unit."""
    wanted: Wanted
    measure: Callable[[Plan, "Row"], list[Line]]
    """Its lines; raises NotMeasured."""
