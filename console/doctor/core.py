"""The check of the compiled core: which of its libraries compute here, and why numpy does otherwise."""

from agents.core import compiled_crew
from agents.laws.core import formula_index
from console.doctor.finding import Finding, ok, warning
from fes.arithmetic.core import functions, library
from fes.system import distribution
from world.simulation.core import compiled_world

CHECK = "core"

COMPILER = "a C compiler (Debian: apt-get install gcc libc6-dev; macOS: xcode-select --install)"

SAME = "numpy computes, more slowly and with the same digits"


def libraries() -> dict[str, str]:
    """Each library of this installation -> `c`, or the reason why numpy computes instead; all are loaded.

    Raises FesError where FES_CORE demands a library that cannot be used.
    """
    for load in (functions.load, compiled_crew.load, formula_index.load, compiled_world.load):
        load()
    return dict(library.state)


def core(states: dict[str, str] | None = None) -> Finding:
    """The core that computes here, by the states of its libraries."""
    if library.choice() == library.NUMPY:
        return ok(CHECK, f"numpy, because {library.VARIABLE} is '{library.NUMPY}': unset it for the compiled core")
    known = libraries() if states is None else states
    reasons = {name: state for name, state in known.items() if state != library.C}
    if not reasons:
        return ok(CHECK, f"compiled: {', '.join(known)} repeat numpy's digits")
    if len(reasons) == len(known) and set(reasons.values()) == {library.NOT_BUILT}:
        remedy = f"install {COMPILER}, then {distribution.install()}"
        return warning(CHECK, f"{SAME}: the compiled core was not built", remedy)
    seen = "; ".join(f"the library '{name}' is not used: {reason}" for name, reason in reasons.items())
    return warning(CHECK, f"{SAME}, in part or in whole: {seen}", f"CC=clang {distribution.install()}")
