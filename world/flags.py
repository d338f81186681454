"""The command line of fes-world."""

import argparse
from pathlib import Path

from fes import command_line
from world.config import builtin
from world.config.scenario import parse_override
from world.execution.checkpoint import PERIOD


def parser() -> command_line.OneLineParser:
    """The parser of all flags."""
    parser = command_line.OneLineParser(
        prog="fes-world",
        description="Ground truth and radio channel of a run.",
        epilog="example: fes-world pair --out runs/by-hand",
    )
    parser.add_argument("scenario", nargs="?", metavar="SCENARIO", help=builtin.ARGUMENT)
    parser.add_argument("--resume", type=Path, metavar="RUN_DIR", help="resume the run of this directory")
    parser.add_argument("--name", help="name of the scenario in the summary (default: the name of its file)")
    add_scenario_flags(parser)
    parser.add_argument(
        "--rtf",
        type=command_line.real_time_factor,
        metavar="max|X",
        help="pace: simulated seconds per second, or max for full speed (the default)",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="run directory for scenario, summary and log")
    parser.add_argument(
        "--checkpoint",
        type=command_line.period,
        default=PERIOD,
        metavar="S",
        help="time between two checkpoints in --out [s]; 0 for none (default: %(default)g)",
    )
    parser.add_argument("--no-record", action="store_true", help="write no log (run.mcap)")
    command_line.add_use_flag(parser)
    command_line.add_network_flags(parser)
    parser.set_defaults(run=None)  # None unless given: a resumed run keeps its name
    return parser


def add_scenario_flags(parser: argparse.ArgumentParser) -> None:
    """Add the flags that override fields of a scenario."""
    parser.add_argument("--set", action="append", default=[], metavar="a.b=c", help="override a field")
    parser.add_argument("--seed", type=int, metavar="N", help="override run.seed")
    parser.add_argument("--duration", type=float, metavar="S", help="override run.duration [s]")


def overrides(flags: argparse.Namespace) -> dict[str, object]:
    """The overrides in the flags, by dotted path."""
    values = dict(parse_override(text) for text in flags.set)
    if flags.seed is not None:
        values["run.seed"] = flags.seed
    if flags.duration is not None:
        values["run.duration"] = flags.duration
    return values
