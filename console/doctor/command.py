"""fes doctor: what may keep a run from starting, or from being seen."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.table import Table

from console.connect import run_directory
from console.connect.options import Cfg, Config, Connect, ObserverKeys
from console.connect.run_directory import Address, Visitor
from console.doctor import installation, machine, network
from console.doctor.finding import Finding, Status, warning
from console.terminal import printing, progress
from console.terminal.printing import cell
from fes import process
from fes.errors import FesError
from fes.protocol import keys
from fes.system import strict_json
from fes.transport.endpoints import DEFAULT_ENDPOINT, Endpoints
from fes.transport.identity import OBSERVER

STYLES = {Status.OK: "green", Status.WARNING: "yellow", Status.FAILED: "bold red"}


def doctor(
    connect: Connect = None,
    config: Config = None,
    cfg: Cfg = None,
    certificates: ObserverKeys = None,
    run: Annotated[str | None, typer.Option(help="Name of a run that should go on.")] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the findings as JSON, and nothing else.")] = False,
) -> int:
    """Check this machine, and a run that goes on (by default the latest one started in this folder)."""
    who = Visitor(OBSERVER, certificates, run or keys.DEFAULT_RUN, network.PATIENCE)
    where: Endpoints | Finding
    try:
        where = run_directory.reach(who, connect, config, cfg)
    except FesError as error:
        where = network.refused(error)
    named = bool(connect or config or run)
    announced = run_directory.announced(who.run)
    if announced is not None and (
        connect or config or cfg or isinstance(where, Finding) or announced[1].endpoint not in where.connect
    ):
        announced = None  # it is not where we look

    async def look() -> int:
        with progress.waiting("looking at this machine and its runs"):
            findings = await examine(where, who.run, named or announced is not None)
        if announced is not None:
            findings = [awaited(found, *announced) for found in findings]
        if json_:
            print(strict_json.dumps([finding._asdict() for finding in findings], indent=2))
        else:
            printing.show(printing.console(), table(findings))
        return process.FAILURE if any(found.status is Status.FAILED for found in findings) else process.SUCCESS

    process.leave("fes", look, needs_its_end=True)


async def examine(where: Endpoints | Finding, run: str, wanted: bool) -> list[Finding]:
    """All checks; those of the machine in a thread, while the network is asked, if it is known `where`."""
    local = asyncio.create_task(asyncio.to_thread(_local))
    if isinstance(where, Endpoints):
        (seen, robots), places = await network.examine(where, run, wanted), where.connect
    else:
        seen, robots, places = [where], None, ()
    return [
        *await local,
        machine.files(robots),
        machine.directory(run_directory.ROOT),
        *machine.private_keys(run_directory.ROOT),
        machine.loopback(),
        network.port(DEFAULT_ENDPOINT, robots is not None and any(map(network.is_default, places))),
        network.exposure(places[0] if places else DEFAULT_ENDPOINT),
        *seen,
    ]


def _local() -> list[Finding]:
    """The checks that take a moment, of this process's installation and its clock."""
    return [machine.python(), *installation.own(), *machine.packages(), machine.clock()]


def awaited(found: Finding, path: Path, address: Address) -> Finding:
    """A finding on a run that `path` announces: who started it lives, so a world that is not there is about to come,
    or to come back."""
    if found.check != "endpoint" or found.status is not Status.FAILED or "certificate" in found.seen:
        return found
    seen = f"{found.seen}; process {address.pid} goes on with that run, says {path}"
    return warning("endpoint", seen, "its world is away, suspended or just starting: look again")


def table(findings: list[Finding]) -> Table:
    """The findings as a person reads them."""
    shown = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    shown.add_column("check", no_wrap=True)
    shown.add_column("status", no_wrap=True)
    shown.add_column("seen", overflow="fold")
    for found in findings:
        seen = cell(found.seen)
        if found.remedy:
            seen.append("\n").append(cell(f"-> {found.remedy}", "italic"))
        shown.add_row(found.check, cell(found.status, STYLES[found.status]), seen)
    return shown
