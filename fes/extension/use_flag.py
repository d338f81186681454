"""The flag --use of fes-world and fes-agent."""

import argparse
from typing import Any

from fes.extension import registry


def add_use_flag(parser: argparse.ArgumentParser) -> None:
    """Add the flag that allows modules of extensions."""
    parser.add_argument(
        "--use",
        action=_Use,
        default=[],
        metavar="MODULE",
        help="import a module or a file, and allow its extensions; may be repeated",
    )


class _Use(argparse.Action):
    """Imports a module at once."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        registry.use(values)
