"""The process fes-world: startup, main loop and shutdown of a world."""

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
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from fes import command_line, process
from fes.errors import FesError, reason
from fes.protocol import keys, world_info
from fes.recording.layout import NAME
from fes.system import encoding, output
from fes.transport import bus, identity
from fes.transport.bus import Bus
from world.config import builtin, expectations, remarks
from world.config.scenario import Scenario, load
from world.execution import resume
from world.execution.checkpoint import FOLDER, CheckpointWriter, clear, has_checkpoint
from world.execution.directory_lock import exclusive_lock
from world.execution.recorder import Recorder
from world.execution.resume import Resumed
from world.execution.run import Run
from world.execution.snapshot import Snapshot
from world.flags import overrides, parser
from world.metrics import summary
from world.metrics.team import target
from world.server import access, audit, claim
from world.server.server import Options, Server

Summary = dict[str, Any]
_logger = logging.getLogger("world")


class Outcome(Enum):
    """State of a run after the main loop of its world."""

    FINISHED = "all ticks executed: the robots are dismissed, and the checkpoint is deleted once the log is closed"
    PAUSED = "the checkpoint stays, and the robots wait for a world that resumes the run"
    CANCELLED = "the run cannot be resumed: the robots are dismissed, and the checkpoint is deleted"


@dataclass(frozen=True, eq=False)
class Start:
    """A run to be started, or resumed from a checkpoint."""

    scenario: Scenario
    name: str
    """Name of the scenario."""
    run: str
    """Name of the run in every key."""
    saved: Snapshot | None = None
    """State from which the run is resumed; None for a new run."""


class World:
    """A world process between startup and exit."""

    def __init__(self, flags: argparse.Namespace, start: Start, opened: Bus, recorder: Recorder | None) -> None:
        self._out: Path | None = flags.out
        self._recorder = recorder
        self._run, self._checkpoints, elapsed = _open_run(flags, start, recorder)
        self._first_tick = self._run.state.tick
        self._is_cancelled = False
        # With --exit-with-stdin a launcher resumed the run, and its Ctrl-C always ends it.
        self._is_resumed_by_person = start.saved is not None and not flags.exit_with_stdin
        on_change = partial(summary.write_scenario, flags.out) if flags.out is not None else None
        options = Options(flags.rtf, self._checkpoints, elapsed, guarded=bool(flags.keys), on_change=on_change)
        self.server = Server(opened, self._run, start.name, start.run, options)
        if on_change is not None:
            on_change(self._run.scenario)

    async def main_loop(self) -> None:
        """Gather the robots, and execute the ticks that are left."""
        try:
            if not self._run.is_over:
                await self.server.gather()
            await self.server.main_loop()
        except asyncio.CancelledError as stop:
            # Only Ctrl-C ends a run permanently. Exception: a resumed world that is still waiting for its robots. A
            # person may have resumed it with a wrong flag.
            is_waiting = self._is_resumed_by_person and self._run.state.tick == self._first_tick
            self._is_cancelled = stop.args == (signal.SIGINT.name,) and not is_waiting
            if self.outcome is Outcome.PAUSED:
                self.server.save()
            raise

    @property
    def outcome(self) -> Outcome:
        """The outcome if the main loop ended now."""
        if self._run.is_over:
            return Outcome.FINISHED
        return Outcome.CANCELLED if self._is_cancelled or self._checkpoints is None else Outcome.PAUSED

    def shutdown(self) -> Summary | None:
        """Dismiss the robots unless the run is paused; write and return the summary."""
        outcome = self.outcome
        self._log_early_end(outcome)
        try:
            if outcome is not Outcome.PAUSED:
                self.server.dismiss()
            self.server.log_drops()
        finally:
            results = self._write_summary()
            if outcome is Outcome.CANCELLED:
                self.discard_checkpoint()
            elif self._checkpoints is not None:
                self._checkpoints.close(self._run)
        return results

    def discard_checkpoint(self) -> None:
        """Delete the checkpoint: the run is over."""
        if self._checkpoints is not None:
            self._checkpoints.discard(self._run)

    def _log_early_end(self, outcome: Outcome) -> None:
        if outcome is Outcome.FINISHED:
            return
        text = "ended early"
        if outcome is Outcome.PAUSED:
            assert self._out is not None
            text = f"paused: fes-world --resume {self._out} continues it"
            if self._run.state.tick == self._first_tick:
                text += f"; to end it permanently, remove {self._out / FOLDER}"
        _logger.info("tick %d of %d: %s", self._run.state.tick, self._run.scenario.ticks, text)

    def _write_summary(self) -> Summary | None:
        results = self.server.summarize()
        if self._recorder is not None:
            self._recorder.conclude(results)
        if results is not None and self._out is not None:
            summary.write(self._out, results)
        for line in summary.lines(results) if results is not None else []:
            _logger.info("summary: %s", line)
        return results


async def serve(flags: argparse.Namespace, start: Start) -> int:
    """Startup, main loop and shutdown of a world process; returns the exit code."""
    for line in [*remarks.of(start.scenario), *target.remarks(start.scenario)] if start.saved is None else []:
        _logger.warning("%s", line)
    crews = identity.crews(flags.keys) if flags.keys else ()
    rules = access.control(start.run, start.scenario.robots.number, crews) if flags.keys else None
    endpoints = command_line.world_endpoints(flags, rules)
    audited = audit.running(access.roles(rules), _logger) if rules else nullcontext()
    async with audited, bus.opened(endpoints) as opened:
        connected = bool(flags.connect or flags.config or flags.cfg) or flags.mode not in (None, "router")
        await claim.claim_run(opened, start.run, connected=connected)
        with _open_log(flags, start) as recorder:
            world = World(flags, start, opened, recorder)
            try:
                await world.main_loop()
            finally:
                results = world.shutdown()
        world.discard_checkpoint()  # the log is closed: until now the run could be resumed
        with contextlib.suppress(asyncio.CancelledError):  # the results are written: a signal only ends the wait
            await world.server.linger()
        _logger.info("the run is over after %d ticks", start.scenario.ticks)
    return _judge(results)


def _judge(results: Summary | None) -> int:
    """Log each expectation of the scenario with its verdict; returns the exit code."""
    for verdict in results["expectations"] if results else []:
        level = logging.INFO if verdict["holds"] else logging.ERROR
        holds = "as expected" if verdict["holds"] else "not as expected"
        _logger.log(level, f"{holds}: %(of)s is %(seen)s, expected to be %(expected)s", verdict)
    return process.UNMET if results and expectations.unmet(results) else process.SUCCESS


def _open_log(flags: argparse.Namespace, start: Start) -> AbstractContextManager[Recorder | None]:
    """The log of the run; None if it has none. Clears the run directory of a new run."""
    if start.saved is not None:
        return resume.recorder(flags.out, start.saved) or nullcontext()
    if flags.out is not None:
        if has_checkpoint(flags.out):
            _logger.warning("the checkpoint in %s is deleted: its run can no longer be resumed", flags.out)
        clear(flags.out)  # before the log: without its log a checkpoint is worthless
        summary.clear(flags.out)
        (flags.out / NAME).unlink(missing_ok=True)
    if flags.out is None or flags.no_record:
        return nullcontext()
    return Recorder(flags.out / NAME, start.scenario, start.name, "processes")


def _open_run(
    flags: argparse.Namespace, start: Start, recorder: Recorder | None
) -> Resumed | tuple[Run, CheckpointWriter | None, float]:
    """The run, new or resumed, the writer of its checkpoints, and the wall-clock time since its tick 0 [s]."""
    if start.saved is not None:
        return resume.run(flags.out, start.saved, recorder, flags.checkpoint or math.inf)
    if flags.out is None or not flags.checkpoint:
        return Run(start.scenario, recorder), None, 0.0
    checkpoints = CheckpointWriter(flags.out, flags.checkpoint, start.name, start.run)
    run = Run(start.scenario, recorder, checkpoints.note)
    checkpoints.begin(run)
    return run, checkpoints, 0.0


def _read_flags(flags: argparse.Namespace, locks: contextlib.ExitStack) -> Start:
    """The run that the flags describe; its run directory is locked by `locks`. Raises FesError."""
    if flags.resume is None:
        if flags.scenario is None:
            raise FesError("give a SCENARIO, or --resume RUN_DIR")
        run = keys.check_run(keys.DEFAULT_RUN if flags.run is None else flags.run)
        path = builtin.resolve(Path(flags.scenario))
        scenario = load(path, overrides(flags))
        _check_pace(flags, scenario)
        if flags.out is not None:
            flags.out.mkdir(parents=True, exist_ok=True)
            locks.enter_context(exclusive_lock(flags.out))
            summary.write_scenario(flags.out, scenario)
        return Start(scenario, encoding.check_name(flags.name) if flags.name else encoding.name_of(path), run)
    if flags.scenario or flags.out or flags.name or flags.no_record or overrides(flags):
        raise FesError("--resume keeps the settings of the run: give no SCENARIO, and no flag that sets them")
    locks.enter_context(exclusive_lock(flags.resume))
    saved = resume.load(flags.resume)
    if flags.run not in (None, saved.run):
        raise FesError(f"--resume continues run '{saved.run}', not run '{flags.run}'")
    _check_pace(flags, saved.scenario)
    flags.out = flags.resume
    return Start(saved.scenario, saved.name, keys.check_run(saved.run), saved)


def _check_pace(flags: argparse.Namespace, scenario: Scenario) -> None:
    if flags.rtf is not None and scenario.run.clock == "live":
        raise FesError("--rtf does not go with the live clock, which follows the wall clock")


def main() -> None:
    """Run fes-world."""
    output.configure()
    command_line = parser()
    flags = command_line.parse_args()
    with contextlib.ExitStack() as locks:
        try:
            world_info.version()  # log and checkpoints need it: fail now if the package has none
            start = _read_flags(flags, locks)
        except OSError as error:
            command_line.error(reason(error))
        except FesError as error:
            command_line.error(str(error))
        process.run("fes-world", lambda: serve(flags, start), exit_with_stdin=flags.exit_with_stdin)


if __name__ == "__main__":
    main()
