"""The base that world, agents and observers share, and the Python interface: load, run, read, sweep and Run.

arrays        arrays, edges, geometry, keyed random draws
arithmetic    elementary functions and sums, with the same bits on every processor
shapes        shapes of a team, and routes over relays
model         settings, sensing, contacts, the objective and the outage formula
extension     the public interface for extensions: laws, channels, dynamics, metrics
protocol      key expressions, messages and their encoding
ros           bytes and keys of ROS 2, for the drivers of real robots
transport     a Zenoh session, and the way of its samples to asyncio
recording     the log of a run: format, writer and reader
system        files, signals, output and memory of the machine
process       signals, exit codes and messages of a process
command_line  the flags that world and agents share
errors        every error, on one page
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from console.api.execution import read, run
    from console.api.result import Run
    from console.api.scenarios import load
    from console.api.sweeping import sweep

__all__ = ["Run", "load", "read", "run", "sweep"]

_INTERFACE = {
    "load": "console.api.scenarios",
    "run": "console.api.execution",
    "read": "console.api.execution",
    "sweep": "console.api.sweeping",
    "Run": "console.api.result",
}
"""Modules of the Python interface. They are above this package, so each is loaded when it is used: an agent, which
imports this package, never loads the console."""


if not TYPE_CHECKING:  # a type checker would accept any name

    def __getattr__(name: str) -> Any:
        """A name of the Python interface, loaded at its first use (PEP 562)."""
        if name not in _INTERFACE:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = globals()[name] = getattr(import_module(_INTERFACE[name]), name)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
