"""The shell of the world: fes-world."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small

import argparse
import contextlib
import logging
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from fes import bus, identity, keys, process
from fes.errors import FesError
from world import access, audit, claim, expect, summary
from world.recorder import NAME, Recorder
from world.scenario import Scenario, load, parse_override
from world.server import Server


async def serve(flags: argparse.Namespace, scenario: Scenario) -> int:
    """One world process, from start to exit code."""
    run, name = keys.check_run(flags.run), flags.name or Path(flags.scenario).stem
    rules = access.control(run, scenario.robots.number, identity.crews(flags.keys)) if flags.keys else None
    endpoints = process.world_endpoints(flags, rules)
    async with audit.kept() if flags.keys else contextlib.nullcontext(), bus.opened(endpoints) as opened:
        connected = bool(flags.connect or flags.config or flags.cfg) or flags.mode not in (None, "router")
        await claim.claim(opened, run, connected=connected)
        with _recorder(flags, scenario, name) as recorder:
            server = Server(opened, scenario, name, run, flags.rtf, recorder)
            if flags.out is not None:
                server.keep = partial(summary.write_scenario, flags.out)
            reached = None
            try:
                await server.gather()
                await server.run()
            finally:
                try:
                    server.dismiss()
                    server.complaints.log_total(server.overflow)
                finally:
                    reached = _keep(flags.out, server, recorder)
        server.logger.info("the run is over after %d ticks", scenario.ticks)
    for verdict in reached["expectations"] if reached else []:
        level = logging.INFO if verdict["holds"] else logging.ERROR
        server.logger.log(level, "%(of)s is %(seen)s, expected to be %(expected)s", verdict)
    return process.UNMET if reached and expect.unmet(reached) else process.SUCCESS


def _recorder(flags: argparse.Namespace, scenario: Scenario, name: str) -> AbstractContextManager[Recorder | None]:
    """The log of the run, or none."""
    if flags.out is None or flags.no_record:
        return nullcontext()
    return Recorder(flags.out / NAME, scenario, name, "processes")


def _keep(out: Path | None, server: Server, recorder: Recorder | None) -> dict[str, Any] | None:
    """Keep what was reached: the summary, which is returned."""
    reached = server.summarize()
    if recorder is not None:
        recorder.conclude(reached)
    if reached is not None and out is not None:
        summary.write(out, reached)
    for line in summary.lines(reached) if reached is not None else []:
        server.logger.info("summary: %s", line)
    return reached


def main() -> None:
    """Entry point of fes-world."""
    parser = process.OneLineParser(prog="fes-world", description="Ground truth and radio channel of a run.")
    parser.add_argument("scenario", metavar="SCENARIO", help="a scenario file, such as configs/paper.toml")
    parser.add_argument("--name", help="name of the scenario in the summary (default: that of its file)")
    add_scenario_flags(parser)
    parser.add_argument("--rtf", type=process.real_time_factor, metavar="max|X", help="pace: simulated s per s")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to leave scenario, summary and log")
    parser.add_argument("--no-record", action="store_true", help="write no log (run.mcap)")
    process.add_network_flags(parser)
    flags = parser.parse_args()
    try:
        scenario = load(Path(flags.scenario), overrides(flags))
        if flags.out is not None:
            flags.out.mkdir(parents=True, exist_ok=True)
            summary.write_scenario(flags.out, scenario)
    except (FesError, OSError) as error:
        parser.error(str(error))
    process.run("fes-world", lambda: serve(flags, scenario), exit_with_stdin=flags.exit_with_stdin)


def add_scenario_flags(parser: argparse.ArgumentParser) -> None:
    """The flags that override fields of a scenario."""
    parser.add_argument("--set", action="append", default=[], metavar="a.b=c", help="override a field")
    parser.add_argument("--seed", type=int, metavar="N", help="override run.seed")
    parser.add_argument("--duration", type=float, metavar="S", help="override run.duration [s]")


def overrides(flags: argparse.Namespace) -> dict[str, object]:
    """The overrides in the flags, by dotted path."""
    found = dict(parse_override(text) for text in flags.set)
    if flags.seed is not None:
        found["run.seed"] = flags.seed
    if flags.duration is not None:
        found["run.duration"] = flags.duration
    return found


if __name__ == "__main__":
    main()
