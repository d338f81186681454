"""The command `fes`, and those of its commands that run or show a scenario."""

import argparse
import signal
import sys
from contextlib import nullcontext
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from console import guide, schema
from console.analysis import command as analysis_command
from console.backends import announcement, inprocess, processes, view
from console.backends.processes import Launch
from console.check.command import check
from console.connect import index_source, options, run_directory, set_command
from console.dashboard import command as dashboard_command
from console.dashboard import live, summary
from console.doctor.command import doctor
from console.fit import command as fit_command
from console.keys import command as keys_command
from console.replay import command as replay_command
from console.replay import compare
from console.sweep import command
from console.team import command as team_command
from console.team import table_command
from console.terminal import printing, progress
from fes import command_line, process
from fes.errors import FesError, ScenarioError, no_memory, reason
from fes.protocol.world_info import version
from fes.recording.layout import NAME
from fes.system import encoding, output, signals, strict_json
from world.config import builtin, expectations
from world.config.scenario import Scenario, load, parse_override
from world.execution.recorder import Recorder
from world.metrics.summary import write, write_scenario
from world.simulation import crowd

INTERRUPTED = 130
"""Exit code that Typer returns for a KeyboardInterrupt."""

DISTURBED = "the digest is not that of an undisturbed run"

app = typer.Typer(
    cls=guide.CommandsByUse,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    epilog=guide.OVERVIEW,
)

guide.command(app, "view")(dashboard_command.view)
guide.command(app, "set")(set_command.set_command)
guide.command(app, "replay")(replay_command.replay)
guide.command(app, "compare")(compare.compare)
guide.command(app, "sweep")(command.sweep)
guide.command(app, "plot")(analysis_command.plot)
guide.command(app, "fit")(fit_command.fit)
guide.command(app, "schema")(schema.schema)
guide.command(app, "check")(check)
guide.command(app, "doctor")(doctor)
guide.command(app, "claims")(analysis_command.show_claims)
guide.command(team_command.app, "team run")(table_command.run)
for name, group in (("keys", keys_command.app), ("team", team_command.app)):
    app.add_typer(group, name=name, epilog=f"\b\nExample: {guide.EXAMPLES[name]}")


class Backend(StrEnum):
    """Placement of the robots."""

    PROCESSES = "processes"
    INPROCESS = "inprocess"


class Clock(StrEnum):
    """The values of run.clock, which `fes.model.config.Clock` describes."""

    LOCKSTEP = "lockstep"
    LIVE = "live"


def _version(wanted: bool) -> None:
    if wanted:
        printing.line(version())
        raise typer.Exit


@app.callback()
def about(
    version_: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Distributed extremum seeking: robots that together find the best separation for their radio."""


@guide.command(app, "run", guide.listing("Built-in scenarios", builtin.names()))
def run(
    scenario: options.Scenario,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="A.B=C", help=options.SET)] = None,
    use: options.Use = None,
    seed: Annotated[int | None, typer.Option(help="Override run.seed.")] = None,
    duration: Annotated[float | None, typer.Option(help="Override run.duration [s].")] = None,
    backend: Annotated[Backend, typer.Option(help="Run processes over Zenoh, or all robots in one loop.")] = (
        Backend.PROCESSES
    ),
    agents_per_process: Annotated[int, typer.Option(min=1, help="Robots hosted by each agent.")] = 1,
    clock: Annotated[Clock | None, typer.Option(help="Override run.clock.")] = None,
    rtf: Annotated[str, typer.Option(metavar="max|X", help=options.PACE)] = "max",
    out: Annotated[Path | None, typer.Option(help="Run directory (default runs/<scenario>-<n>).")] = None,
    secure: Annotated[bool, typer.Option("--secure", help="Use TLS, with certificates made for this run.")] = False,
    headless: Annotated[bool, typer.Option("--headless", help="Show no dashboard.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print the summary as JSON, and nothing else.")] = False,
    record: Annotated[bool, typer.Option(help="Write a log of every message, run.mcap.")] = True,
    respawn: Annotated[
        bool, typer.Option("--respawn", help="Restart agents that die, each with all of its robots.")
    ] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help=options.VERBOSE)] = False,
) -> int:
    """Run a scenario: world, robots and dashboard.

    An agent that dies does not end the run. Its robots stand still until another agent hosts them.
    """
    fields = [("run.seed", seed), ("run.duration", duration), ("run.clock", clock)]
    overrides = [*(set_ or []), *(f"{field}={value}" for field, value in fields if value is not None)]
    with process.interruptible():
        path = builtin.resolve(scenario)
        loaded = load(path, dict(parse_override(text) for text in overrides))
        crowd.check(loaded)
        in_process, pace = backend is Backend.INPROCESS, _pace(rtf)
        for flag, given in (("--secure", secure), ("--respawn", respawn)):
            if given and in_process:
                raise FesError(f"{flag} needs --backend processes: one loop has no processes of its own")
        if in_process:
            inprocess.check(loaded)
        elif loaded.run.clock == "live" and pace is not None:
            raise FesError("--rtf does not go with the live clock, which follows the wall clock")
        name, screen = encoding.name_of(path), printing.console(stderr=json_)
        dashboard = printing.is_screen(screen) and not headless and not json_
        launch = Launch(name, agents_per_process, rtf, dashboard, record, secure, respawn)
        if not in_process:
            processes.check(launch, loaded)
        with run_directory.created(path.stem, out) as directory:
            announcement.announce(loaded, in_process, launch)
            write_scenario(directory.path, loaded)
            if in_process:
                log = Recorder(directory.path / NAME, loaded, name, backend.value) if record else nullcontext()
                with log as recorder:
                    terminal = screen if dashboard else None
                    result = _in_process(loaded, name, pace, directory.path, terminal, recorder)
            else:
                result = processes.run(launch, loaded, directory, view.on_screen(screen, dashboard, loaded))
            if absences := result.get("unscheduled_absences"):
                process.warn("fes", f"unscheduled absences: {absences} robot-ticks; {DISTURBED}")
            if json_:
                print(strict_json.dumps(result), flush=True)
            else:
                printing.show(screen, summary.render(result, verbose))
                printing.line(f"run directory: {directory.path}")
                printing.show(screen, summary.last_line(result))
    return process.UNMET if expectations.unmet(result) else process.SUCCESS


def main() -> None:
    """Entry point of fes: print each error in one line, and exit with the code of its kind."""
    output.configure()
    try:
        if signal.SIGINT in signals.heard():
            signal.signal(signal.SIGINT, signal.default_int_handler)  # replaces the handler of the start-up
        version()  # a command installed by an older clone skips the check in `fes_robots`
        code = typer.main.get_command(app)(standalone_mode=False)
    except KeyboardInterrupt:
        code = INTERRUPTED
    except FesError as error:
        process.complain("fes", str(error))
        for note in getattr(error, "__notes__", ()):
            process.tell(f"fes: {note}")
        code = error.exit_code
    except OSError as error:
        process.complain("fes", reason(error))
        code = process.FAILURE
    except MemoryError as error:
        process.complain("fes", no_memory(error))
        code = process.FAILURE
    except Exception as error:
        # Typer's errors about arguments format themselves in one line.
        format_message = getattr(error, "format_message", None)
        if format_message is None:
            raise
        message = format_message().replace("Value error, ", "")
        if message.startswith("Missing"):
            message = f"{message.rstrip('.')}; see {error.ctx.command_path} --help"  # type: ignore[attr-defined]
        if message.startswith("Usage:"):  # without a command the message is the full help
            for text in message.splitlines():
                process.tell(text)
        else:
            process.complain("fes", message or "expects a command; see fes --help")
        code = process.FAILURE
    if code == INTERRUPTED:
        process.complain("fes", "stopped by SIGINT")
        code = process.FAILURE
    sys.exit(code if isinstance(code, int) else process.SUCCESS)


def _pace(text: str) -> float | None:
    """The pace in the argument of --rtf [simulated seconds per second]; None for full speed."""
    try:
        return command_line.real_time_factor(text)
    except argparse.ArgumentTypeError as error:
        raise ScenarioError("--rtf", str(error)) from None


def _in_process(
    scenario: Scenario,
    name: str,
    pace: float | None,
    directory: Path,
    screen: Console | None,
    recorder: Recorder | None,
) -> dict[str, Any]:
    def store(result: dict[str, Any]) -> None:
        write(directory, result)
        if recorder is not None:
            recorder.conclude(result)

    if screen is None:
        with progress.shown(name, scenario.ticks) as bar:
            watch = (lambda report: bar(report.tick + 1)) if bar.is_shown else None
            return inprocess.run(scenario, name, pace, watch, store, recorder)
    with live.Screen(screen, summary.below(scenario), source=index_source.of(scenario)) as frames:
        return inprocess.run(scenario, name, pace, frames.show, store, recorder)
