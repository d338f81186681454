"""Entry point of fes: handles stop signals before it imports the rest."""

from fes import signals


def main() -> None:
    """Run fes."""
    signals.hold(1, "fes")
    from console import cli

    cli.main()


if __name__ == "__main__":
    main()
