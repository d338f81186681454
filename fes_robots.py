"""The commands `fes`, `fes-world` and `fes-agent`, from the first line on.

The packages `fes`, `agents`, `world` and `console` have names that others use too, and a package of another project
that Python finds first would end every command in a traceback. This module, whose name no other project uses,
imports none of them before it knows that they are ours, and that this system can run them. It also imports next to
nothing itself until a Ctrl-C ends a command without a traceback.
"""

import signal
import sys

NEEDED = ("fcntl", "resource", "termios")
"""Modules of Python that only Unix has."""


def trouble() -> str:
    """Reason why no command can run here, in one line; empty if they can."""
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
    ours = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ours)
    if found := next(ours.foreign(), ""):
        return f"{found}; {ours.separate()}"
    return str(ours.absence())


def fes() -> None:
    """Entry point of fes."""
    _start("fes", "console.__main__")


def fes_world() -> None:
    """Entry point of fes-world."""
    _start("fes-world", "world.__main__")


def fes_agent() -> None:
    """Entry point of fes-agent."""
    _start("fes-agent", "agents.__main__")


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
