"""The `fes` command: what a person runs."""

import argparse
import json
import sys
from contextlib import nullcontext
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from console import compare, evidence, inprocess, keyring, processes, replay, rundir, setting, summary, view
from console.doctor.command import doctor
from console.options import Cfg, Config, Connect, ObserverKeys
from console.processes import Launch
from console.rundir import Visitor
from console.sweep import command
from fes import bus, distribution, keys, process
from fes.errors import FesError, ScenarioError, reason
from fes.identity import OBSERVER
from world import expect
from world.recorder import NAME, Recorder
from world.scenario import Scenario, load, parse_override
from world.summary import write, write_scenario

INTERRUPTED = 130
"""What Typer makes of a KeyboardInterrupt."""

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None)


app.command()(evidence.plot)
app.command(name="claims")(evidence.show_claims)
app.command(name="set")(setting.set_command)
app.command()(replay.replay)
app.command()(compare.compare)
app.command()(command.sweep)
app.command()(doctor)
app.add_typer(keyring.app, name="keys")


class Backend(StrEnum):
    """Where the robots run."""

    PROCESSES = "processes"
    INPROCESS = "inprocess"


def _version(wanted: bool) -> None:
    if wanted:
        print(distribution.version())
        raise typer.Exit


@app.callback()
def about(
    version_: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Formation by extremum seeking: robots that find the best separation for their radio together."""


@app.command()
def run(
    scenario: Annotated[Path, typer.Argument(help="A scenario file, such as configs/paper.toml.")],
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="A.B=C", help="Override a field.")] = None,
    seed: Annotated[int | None, typer.Option(help="Override run.seed.")] = None,
    duration: Annotated[float | None, typer.Option(help="Override run.duration [s].")] = None,
    backend: Annotated[Backend, typer.Option(help="One process a robot over Zenoh, or all in one loop.")] = (
        Backend.PROCESSES
    ),
    agents_per_process: Annotated[int, typer.Option(min=1, help="Robots hosted by each agent.")] = 1,
    clock: Annotated[str | None, typer.Option(help="Override run.clock.")] = None,
    rtf: Annotated[str, typer.Option(metavar="max|X", help="Pace: simulated seconds a second.")] = "max",
    out: Annotated[Path | None, typer.Option(help="Run directory (default runs/<scenario>-<n>).")] = None,
    secure: Annotated[bool, typer.Option("--secure", help="TLS, with certificates made for this run.")] = False,
    headless: Annotated[bool, typer.Option("--headless", help="No dashboard.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print the summary as JSON, and nothing else.")] = False,
    record: Annotated[bool, typer.Option(help="Write a log of every message, run.mcap.")] = True,
) -> int:
    """Run a scenario: world, robots and dashboard."""
    fields = [("run.seed", seed), ("run.duration", duration), ("run.clock", clock)]
    overrides = [*(set_ or []), *(f"{field}={value}" for field, value in fields if value is not None)]
    loaded = load(scenario, dict(parse_override(text) for text in overrides))
    pace = _pace(rtf)
    if secure and backend is Backend.INPROCESS:
        raise FesError("--secure needs --backend processes: what stays in one loop needs no certificates")
    if backend is Backend.INPROCESS:
        inprocess.check(loaded)
    elif loaded.run.clock == "live" and pace is not None:
        raise FesError("--rtf does not go with the live clock: its pace is that of the wall clock")
    directory = rundir.create(scenario.stem, out)
    write_scenario(directory, loaded)
    screen = Console(stderr=json_)
    dashboard = screen.is_terminal and not headless and not json_
    if backend is Backend.INPROCESS:
        recording = Recorder(directory / NAME, loaded, scenario.stem, backend.value) if record else nullcontext()
        with recording as recorder:
            result = _in_process(loaded, scenario.stem, pace, directory, screen if dashboard else None, recorder)
    else:
        launch = Launch(scenario.stem, agents_per_process, rtf, dashboard, record, secure)
        result = processes.run(launch, loaded, directory, screen)
    if json_:
        print(json.dumps(result))
    else:
        screen.print(summary.render(result))
        screen.print(f"run directory: {directory}", highlight=False)
    return process.UNMET if expect.unmet(result) else process.SUCCESS


@app.command(name="view")
def view_command(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: ObserverKeys = None,
    run: Annotated[str, typer.Option(help="Name of the run.")] = keys.DEFAULT_RUN,
    picture: Annotated[Path | None, typer.Option(help="Write the last frame to this SVG file.")] = None,
    timeout: Annotated[
        float, typer.Option(min=1e-3, max=process.YEAR, help="Give up when no world is there for so long [s].")
    ] = 30.0,
) -> int:
    """Show a run that goes on in another terminal (by default the latest one started in this folder)."""
    visitor = Visitor(OBSERVER, certificates, run, timeout)
    endpoints = rundir.reach(visitor, connect, config, cfg)
    screen = Console()

    async def show() -> int:
        async with bus.opened(endpoints) as opened:
            with view.Screen(screen) as shown:
                await view.watch(opened, run, timeout, shown)
        screen.print(shown.frame())
        if picture is not None:
            view.save_picture(picture, shown.frame(), screen.width, screen.height, "fes view")
        return process.SUCCESS

    process.leave("fes", show)


def main() -> None:
    """Entry point of fes: every error is one line, and the exit code says which kind it was."""
    command = typer.main.get_command(app)
    try:
        code = command(standalone_mode=False)
    except FesError as error:
        process.complain("fes", str(error))
        for note in getattr(error, "__notes__", ()):
            print(f"fes: {note}", file=sys.stderr)
        code = error.exit_code
    except OSError as error:
        process.complain("fes", reason(error))
        code = process.FAILURE
    except Exception as error:
        # Typer's own complaints about arguments know how to say themselves in one line.
        message = getattr(error, "format_message", None)
        if message is None:
            raise
        said = message().replace("Value error, ", "")
        if said.startswith("Usage:"):  # without a command it is the whole help, and no error of one line
            print(said, file=sys.stderr)
        else:
            process.complain("fes", said or "expects a command; see fes --help")
        code = process.FAILURE
    if code == INTERRUPTED:
        process.complain("fes", "stopped by SIGINT")
        code = process.FAILURE
    sys.exit(code if isinstance(code, int) else process.SUCCESS)


def _pace(text: str) -> float | None:
    """The argument of --rtf; None for full speed."""
    try:
        return process.real_time_factor(text)
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
    def keep(reached: dict[str, Any]) -> None:
        write(directory, reached)
        if recorder is not None:
            recorder.conclude(reached)

    with process.interruptible():
        if screen is None:
            return inprocess.run(scenario, name, pace, keep=keep, recorder=recorder)
        with view.Screen(screen) as shown:
            return inprocess.run(scenario, name, pace, shown.show, keep, recorder)
