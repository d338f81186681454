"""The values of FES_CORE, and the core that each selects."""

import sys
from dataclasses import dataclass

from bench.against.programs import NotMeasured, output

VARIABLE = "FES_CORE"
UNSET = "unset"
"""Word for a program without the variable."""

CHOICES = ("c", "numpy", UNSET)
NUMPY = "numpy"
"""The core that every machine has."""

_PROBE = "from fes.system import fingerprint; print(fingerprint.table()['core'])"


@dataclass(frozen=True)
class Core:
    """A value of FES_CORE, and its effect."""

    choice: str
    """One of CHOICES."""
    name: str
    """The core in use, as a summary names it."""
    reason: str = ""
    """The reason why it cannot be measured, if so."""

    @property
    def variables(self) -> dict[str, str | None]:
        """The environment variables of a program with this core."""
        return variables(self.choice)

    @property
    def is_compiled(self) -> bool:
        """True for any core but that of numpy."""
        return self.name != NUMPY


def variables(choice: str) -> dict[str, str | None]:
    """The environment variables of a choice."""
    return {VARIABLE: None if choice == UNSET else choice}


def probe(choice: str) -> Core:
    """The core of a choice, as a new process reports it."""
    try:
        name = output([sys.executable, "-c", _PROBE], variables(choice)).strip()
    except NotMeasured as error:
        return Core(choice, choice, str(error))
    return resolve(choice, name)


def resolve(choice: str, name: str) -> Core:
    """The core of a choice that a process reports as `name`."""
    if choice not in (UNSET, name) and name == NUMPY:
        return Core(choice, choice, "the compiled core is not built")
    return Core(choice, name)
