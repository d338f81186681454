"""fes doctor: check this machine and a running run."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.table import Table

from console.connect import run_directory
from console.connect.options import Cfg, Config, Connect, ObserverKeys
from console.connect.run_directory import Address, Client
from console.doctor import core, installation, machine, network
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
    run: Annotated[str | None, typer.Option(metavar="NAME", help="Name of a run that must be running.")] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the findings as JSON, and nothing else.")] = False,
) -> int:
    """Check this machine and a running run (by default the latest one started in this folder)."""
    client = Client(OBSERVER, certificates, run or keys.DEFAULT_RUN, network.PATIENCE)
    target: Endpoints | Finding
    try:
        target = run_directory.endpoints(client, connect, config, cfg)
    except FesError as error:
        target = network.invalid_flags(error)
    is_requested = bool(connect or config or run)
    announced = run_directory.announced(client.run)
    if announced is not None and (
        connect or config or cfg or isinstance(target, Finding) or announced[1].endpoint not in target.connect
    ):
        announced = None  # the checks address another endpoint

    async def check() -> int:
        with progress.waiting("checking this machine and its runs"):
            findings = await examine(target, client.run, is_requested or announced is not None)
        if announced is not None:
            findings = [with_announcement(finding, *announced) for finding in findings]
        if json_:
            print(strict_json.dumps([finding._asdict() for finding in findings], indent=2))
        else:
            printing.show(printing.console(), table(findings))
        return process.FAILURE if any(finding.status is Status.FAILED for finding in findings) else process.SUCCESS

    process.leave("fes", check, needs_its_end=True)


async def examine(target: Endpoints | Finding, run: str, is_requested: bool) -> list[Finding]:
    """All checks: those of the machine in a thread, and concurrently those of the network.

    If `target` is a finding, it takes the place of the checks of a run.
    """
    local = asyncio.create_task(asyncio.to_thread(_local))
    if isinstance(target, Endpoints):
        (findings, robots), endpoints = await network.examine(target, run, is_requested), target.connect
    else:
        findings, robots, endpoints = [target], None, ()
    return [
        *await local,
        machine.files(robots),
        machine.directory(run_directory.ROOT),
        *machine.private_keys(run_directory.ROOT),
        machine.loopback(),
        network.port(DEFAULT_ENDPOINT, robots is not None and any(map(network.is_default, endpoints))),
        network.exposure(endpoints[0] if endpoints else DEFAULT_ENDPOINT),
        *findings,
    ]


def _local() -> list[Finding]:
    """The slower checks, of the installation and of the clock."""
    installed = [machine.python(), *installation.own(), *machine.packages()]
    return [*installed, machine.arithmetic(), core.core(), machine.clock()]


def with_announcement(finding: Finding, path: Path, address: Address) -> Finding:
    """The finding on a run that `path` announces.

    The process that started the run still runs, so an unreachable world is only a warning.
    """
    if finding.check != "endpoint" or finding.status is not Status.FAILED or "certificate" in finding.seen:
        return finding
    seen = f"{finding.seen}; according to {path}, process {address.pid} still executes that run"
    return warning("endpoint", seen, "its world is starting, suspended or being restarted: check again")


def table(findings: list[Finding]) -> Table:
    """The findings, for a terminal."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    rows.add_column("check", no_wrap=True)
    rows.add_column("status", no_wrap=True)
    rows.add_column("seen", overflow="fold")
    for finding in findings:
        seen = cell(finding.seen)
        if finding.remedy:
            seen.append("\n").append(cell(f"-> {finding.remedy}", "italic"))
        rows.add_row(finding.check, cell(finding.status, STYLES[finding.status]), seen)
    return rows
