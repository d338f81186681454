"""Entry points of the commands `fes`, `fes-world`, `fes-agent`, `fes-robot` and `fes-tabletop`.

Other projects may have packages of the same names as ours. If Python found one of those first, each command would end
in a traceback. So this module, whose name is unique, imports our packages only after two checks: Python finds ours,
and this system can run them. Before it has a handler for Ctrl-C, it imports very little.
"""

import signal
import sys

NEEDED = ("fcntl", "resource", "termios")
"""Modules of Python that exist only on Unix."""


def trouble() -> str:
    """The reason in one line why no command can run on this machine; empty otherwise."""
    import importlib.util
    from pathlib import Path

    for name in NEEDED:
        try:
            importlib.import_module(name)
        except ImportError:
            return f"fes runs on Linux and macOS; Python on {sys.platform} has no module '{name}'"
    path = Path(__file__).absolute().parent / "fes" / "system" / "distribution.py"
    spec = importlib.util.spec_from_file_location("fes_robots_distribution", path)
    if spec is None or spec.loader is None or not path.is_file():
        return f"the package 'fes' is missing beside {__file__}: install fes-robots again"
    distribution = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(distribution)
    if conflict := next(distribution.foreign(), ""):
        return f"{conflict}; {distribution.separate()}"
    return str(distribution.absence())


def fes() -> None:
    """Entry point of fes."""
    _start("fes", "console.__main__")


def fes_world() -> None:
    """Entry point of fes-world."""
    _start("fes-world", "world.__main__")


def fes_agent() -> None:
    """Entry point of fes-agent."""
    _start("fes-agent", "agents.__main__")


def fes_tabletop() -> None:
    """Entry point of fes-tabletop."""
    _start("fes-tabletop", "world.tabletop.__main__")


def fes_robot() -> None:
    """Entry point of fes-robot."""
    _start("fes-robot", "field.__main__")


def _start(command: str, module: str) -> None:
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        # no traceback out of an import; `fes.system.signals.hold` follows
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    import importlib

    if why := trouble():
        if sys.stderr is not None:  # print() would take standard output instead
            print(f"{command}: error: {why}", file=sys.stderr)
        raise SystemExit(1)
    importlib.import_module(module).main()
