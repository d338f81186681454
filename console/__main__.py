"""Entry point of fes, which handles stop signals before it imports the rest."""

from fes.process import loading
from fes.system import signals


def main() -> None:
    """Run fes."""
    signals.hold(1, "fes")
    with loading("fes"):
        from console import cli

    try:
        cli.main()
    finally:
        signals.ignore()  # a late signal must not fail a run that has ended, or print a traceback


if __name__ == "__main__":
    main()
