"""Numbers as text, and segments of styled lines."""

import math

from rich.segment import Segment
from rich.style import Style

UNKNOWN = "–"
"""Text for a missing number."""

_UNITS = ((1e3, "km"), (1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))


def styled(text: str, style: str = "") -> Segment:
    """A segment of a line."""
    return Segment(text, Style.parse(style))


def number(value: float, form: str) -> str:
    """`value` in a format; UNKNOWN if it is not finite.

    >>> number(1234.56, ",.1f"), number(math.nan, ",.1f")
    ('1,234.6', '–')
    """
    return format(value, form) if math.isfinite(value) else UNKNOWN


def length(value: float) -> str:
    """A non-negative length [m] in three digits and a suitable unit.

    >>> length(68.1), length(0.0123), length(0.9996), length(math.nan), length(0.0), length(3e-14)
    ('68.1 m', '12.3 mm', '1.00 m', '–', '0 m', '3e-14 m')
    """
    if not math.isfinite(value):
        return UNKNOWN
    size = float(f"{value:.2e}")
    for unit, name in _UNITS:
        if unit <= size < 1e6:
            digits = 2 if size < 10 * unit else 1 if size < 100 * unit else 0
            return f"{size / unit:.{digits}f} {name}"
    return f"{value:.0e} m" if value else "0 m"


def count(value: float) -> str:
    """A count in about five characters; UNKNOWN if it is not finite.

    >>> count(9_999), count(123_456), count(12_345_678), count(math.nan)
    ('9,999', '123k', '12.3M', '–')
    """
    if not math.isfinite(value) or value < 10_000:
        return number(value, ",.0f")
    return f"{value / 1e3:.3g}k" if value < 999_500 else f"{value / 1e6:.3g}M"


def percent(part: float) -> str:
    """A share in at most five characters.

    >>> percent(0.6712), percent(0.9996), percent(math.nan)
    ('67.1%', '100%', '–')
    """
    return number(part, ".1%").replace("100.0%", "100%")
