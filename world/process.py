"""The shell of the world: fes-world."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small

import argparse
import asyncio
import contextlib
import logging
import math
import signal
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fes import process
from fes.errors import FesError, reason
from fes.protocol import keys, world_info
from fes.recording.layout import NAME
from fes.system import encoding, output
from fes.transport import bus, identity
from world.config import builtin, expectations, remarks
from world.config.scenario import Scenario, load, parse_override
from world.execution import resume
from world.execution.checkpoint import FOLDER, PERIOD, CheckpointWriter, clear, has_checkpoint
from world.execution.directory_lock import exclusive_lock
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.execution.snapshot import Snapshot
from world.metrics import summary
from world.server import access, audit, claim
from world.server.server import Server


@dataclass(frozen=True, eq=False)
class Start:
    """A run that is to be started, or gone on with."""

    scenario: Scenario
    name: str
    run: str
    kept: Snapshot | None = None


async def serve(flags: argparse.Namespace, start: Start) -> int:
    """One world process, from start to exit code."""
    run, scenario = start.run, start.scenario
    for line in remarks.of(scenario) if start.kept is None else []:
        logging.getLogger("world").warning("%s", line)
    rules = access.control(run, scenario.robots.number, identity.crews(flags.keys)) if flags.keys else None
    endpoints = process.world_endpoints(flags, rules)
    audited = audit.kept(access.roles(rules)) if rules else contextlib.nullcontext()
    async with audited, bus.opened(endpoints) as opened:
        connected = bool(flags.connect or flags.config or flags.cfg) or flags.mode not in (None, "router")
        await claim.claim_run(opened, run, connected=connected)
        with _recorder(flags, start) as recorder:
            course, checkpoints, elapsed = _course(flags, start, recorder)
            server = Server(
                opened, course, start.name, run, flags.rtf, checkpoints, elapsed, guarded=rules is not None
            )
            if flags.out is not None:
                server.keep = partial(summary.write_scenario, flags.out)
                server.keep(course.scenario)
            reached, first = None, course.state.tick
            goes_on, ended = checkpoints is not None, False
            try:
                if not course.is_over:
                    await server.gather()
                await server.main_loop()
            except asyncio.CancelledError as stopped:
                # Only who means it ends a run for good: no accident, and not who took it up by a wrong flag.
                waited = start.kept is not None and course.state.tick == first and not flags.exit_with_stdin
                ended = course.is_over or (stopped.args == (signal.SIGINT.name,) and not waited)
                goes_on = goes_on and not ended
                if goes_on:
                    server.save()
                raise
            finally:
                goes_on = goes_on and not course.is_over
                if not course.is_over:
                    what = f"paused: fes-world --resume {flags.out} goes on" if goes_on else "ended before its time"
                    if goes_on and course.state.tick == first:
                        what += f"; to end it for good, remove {flags.out / FOLDER}"
                    server.logger.info("tick %d of %d: %s", course.state.tick, scenario.ticks, what)
                try:
                    if not goes_on:  # else the robots wait for a world that goes on
                        server.dismiss()
                    server.drops.log_total(server.overflow, server.strangers)
                finally:
                    reached = _keep(flags.out, server, recorder)
                    if checkpoints is not None:
                        (checkpoints.discard if ended else checkpoints.close)(course)
        if checkpoints is not None:  # last of all: until here it can be gone on with
            checkpoints.discard(course)
        with contextlib.suppress(asyncio.CancelledError):  # the run is over and kept: a signal only ends the wait
            await server.linger()
        server.logger.info("the run is over after %d ticks", scenario.ticks)
    for verdict in reached["expectations"] if reached else []:
        level = logging.INFO if verdict["holds"] else logging.ERROR
        holds = "as expected" if verdict["holds"] else "not as expected"
        server.logger.log(level, f"{holds}: %(of)s is %(seen)s, expected to be %(expected)s", verdict)
    return process.UNMET if reached and expectations.unmet(reached) else process.SUCCESS


def _recorder(flags: argparse.Namespace, start: Start) -> AbstractContextManager[Recorder | None]:
    """The log of the run, or none."""
    if start.kept is not None:
        return resume.recorder(flags.out, start.kept) or nullcontext()
    if flags.out is not None:
        if has_checkpoint(flags.out):
            logging.getLogger("world").warning("the run that %s could have gone on with is given up", flags.out)
        clear(flags.out)  # before the log, without which nobody could go on with it
        summary.clear(flags.out)
        (flags.out / NAME).unlink(missing_ok=True)
    if flags.out is None or flags.no_record:
        return nullcontext()
    return Recorder(flags.out / NAME, start.scenario, start.name, "processes")


def _course(
    flags: argparse.Namespace, start: Start, recorder: Recorder | None
) -> tuple[Run, CheckpointWriter | None, float]:
    """The run, from its start or from where it was left, who keeps it, and the time since tick 0 [s]."""
    if start.kept is not None:
        return resume.run(flags.out, start.kept, recorder, flags.checkpoint or math.inf)
    run = Run(start.scenario, recorder)
    if flags.out is None or not flags.checkpoint:
        return run, None, 0.0
    checkpoints = CheckpointWriter(flags.out, flags.checkpoint, start.name, start.run)
    checkpoints.begin(run)
    return run, checkpoints, 0.0


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


def _start(flags: argparse.Namespace, held: contextlib.ExitStack) -> Start:
    """What the flags ask for, and the run directory to itself while it is `held`; raises FesError."""
    if flags.resume is None:
        if flags.scenario is None:
            raise FesError("give a SCENARIO, or --resume RUN_DIR")
        run = keys.check_run(keys.DEFAULT_RUN if flags.run is None else flags.run)
        path = builtin.resolve(Path(flags.scenario))
        scenario = load(path, overrides(flags))
        _check_pace(flags, scenario)
        if flags.out is not None:
            flags.out.mkdir(parents=True, exist_ok=True)
            held.enter_context(exclusive_lock(flags.out))
            summary.write_scenario(flags.out, scenario)
        return Start(scenario, encoding.check_name(flags.name) if flags.name else encoding.name_of(path), run)
    if flags.scenario or flags.out or flags.name or flags.no_record or overrides(flags):
        raise FesError("--resume goes on with the run as it was: no SCENARIO, and no flag about it")
    held.enter_context(exclusive_lock(flags.resume))
    kept = resume.load(flags.resume)
    if flags.run not in (None, kept.run):
        raise FesError(f"--resume goes on with run '{kept.run}', not with '{flags.run}'")
    _check_pace(flags, kept.scenario)
    flags.out = flags.resume
    return Start(kept.scenario, kept.name, keys.check_run(kept.run), kept)


def _check_pace(flags: argparse.Namespace, scenario: Scenario) -> None:
    if flags.rtf is not None and scenario.run.clock == "live":
        raise FesError("--rtf does not go with the live clock: its pace is that of the wall clock")


def main() -> None:
    """Entry point of fes-world."""
    output.configure()
    parser = process.OneLineParser(
        prog="fes-world",
        description="Ground truth and radio channel of a run.",
        epilog="example: fes-world pair --out runs/by-hand",
    )
    parser.add_argument("scenario", nargs="?", metavar="SCENARIO", help=builtin.ARGUMENT)
    parser.add_argument("--resume", type=Path, metavar="RUN_DIR", help="go on with a run whose world ended before it")
    parser.add_argument("--name", help="name of the scenario in the summary (default: that of its file)")
    add_scenario_flags(parser)
    parser.add_argument("--rtf", type=process.real_time_factor, metavar="max|X", help="pace: simulated s per s")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to leave scenario, summary and log")
    parser.add_argument(
        "--checkpoint",
        type=process.period,
        default=PERIOD,
        metavar="S",
        help="time between two checkpoints in --out [s]; 0 for none (default: %(default)g)",
    )
    parser.add_argument("--no-record", action="store_true", help="write no log (run.mcap)")
    process.add_network_flags(parser)
    parser.set_defaults(run=None)  # a run that is gone on with has its own
    flags = parser.parse_args()
    with contextlib.ExitStack() as held:
        try:
            world_info.version()  # needed by its log and its checkpoints: say now that it has none
            start = _start(flags, held)
        except OSError as error:
            parser.error(reason(error))
        except FesError as error:
            parser.error(str(error))
        process.run("fes-world", lambda: serve(flags, start), exit_with_stdin=flags.exit_with_stdin)


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
