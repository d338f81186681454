"""Entry point of fes: handles stop signals before it imports the rest."""

from fes.system import signals


def main() -> None:
    """Run fes."""
    signals.hold(1, "fes")
    from console import cli

    try:
        cli.main()
    finally:
        signals.ignore()  # none may turn a run that has ended into a failure, or print a traceback


if __name__ == "__main__":
    main()
