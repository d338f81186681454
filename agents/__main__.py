"""Entry point of fes-agent: handles stop signals before it imports the rest."""

from fes.system import signals


def main() -> None:
    """Run fes-agent."""
    signals.hold(0)  # to stop on request is a success for a service
    from agents import process

    process.main()


if __name__ == "__main__":
    main()
