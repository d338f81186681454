"""The table of budgets, as Markdown."""

from collections.abc import Iterable
from dataclasses import dataclass
from statistics import median

HEADER = ("what", "core", "fes", "other", "median (lowest to highest)", "wanted", "")


@dataclass(frozen=True)
class Wanted:
    """A bound on a ratio or a quantity, which may depend on the core."""

    compiled: float
    numpy: float
    at_least: bool = True
    unit: str = ""
    """Unit of the quantity; none for a ratio."""

    def bound(self, is_compiled: bool) -> float:
        """The bound for a core."""
        return self.compiled if is_compiled else self.numpy

    def is_met(self, value: float, is_compiled: bool) -> bool:
        """True if `value` keeps the bound."""
        bound = self.bound(is_compiled)
        return value >= bound if self.at_least else value <= bound

    def text(self, is_compiled: bool) -> str:
        """The bound as it is printed."""
        return f"{'≥' if self.at_least else '≤'} {self.bound(is_compiled):g}{self.unit}"


@dataclass(frozen=True)
class Line:
    """A row of the table: the numbers of each round, or the reason why they are missing."""

    what: str
    core: str
    wanted: Wanted
    is_compiled: bool
    ours: tuple[float, ...] = ()
    """Rate or cost of fes in each round."""
    theirs: tuple[float, ...] = ()
    """Rate or cost of the other side."""
    values: tuple[float, ...] = ()
    """Ratio or quantity of each round, to be compared with the wanted one."""
    reason: str = ""

    def cells(self) -> tuple[str, ...]:
        """The cells of the row."""
        wanted = self.wanted.text(self.is_compiled)
        if not self.values:
            return self.what, self.core, "", "", self.result, wanted, ""
        verdict = "met" if self.wanted.is_met(median(self.values), self.is_compiled) else "**not met**"
        return self.what, self.core, amount(self.ours), amount(self.theirs), self.result, wanted, verdict

    @property
    def result(self) -> str:
        """The median and the spread of the rounds, or the reason why they are missing."""
        if not self.values:
            return f"not measured: {self.reason}"
        digits = 2 if not self.wanted.unit else 0
        middle, low, high = (
            f"{value:.{digits}f}" for value in (median(self.values), min(self.values), max(self.values))
        )
        return f"{middle}{self.wanted.unit} ({low} to {high})"


def amount(values: Iterable[float]) -> str:
    """The median of numbers, with about three digits."""
    numbers = list(values)
    if not numbers:
        return ""
    middle = median(numbers)
    return f"{middle:,.0f}" if middle >= 100 else f"{middle:.3g}"


def markdown(lines: Iterable[Line]) -> str:
    """The table of all lines."""
    rows = [HEADER, ("---",) * len(HEADER), *(line.cells() for line in lines)]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows)
