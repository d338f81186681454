"""Entry point of fes-tabletop: handles stop signals before it imports the rest."""

from fes.process import loading
from fes.system import signals


def main() -> None:
    """Run fes-tabletop."""
    signals.hold(0)  # a service that stops on request exits with success
    with loading("fes-tabletop"):
        from world.tabletop import process

    process.main()


if __name__ == "__main__":
    main()
