"""fes keys: certificates in a directory, and those that live as long as one run."""

import contextlib
import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from console import guide
from console.keys import stale_keys
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError
from fes.protocol.keys import DEFAULT_RUN, MAX_ROBOTS, check_run
from fes.system import signals, strict_json
from fes.transport import identity
from fes.transport.endpoints import Endpoints
from fes.transport.identity import AUTHORITY, OBSERVER, OPERATOR, WORLD
from world.server import access

if TYPE_CHECKING:
    from console.keys.certificates import Authority, Issued

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None, help="Certificates: who is who in a run over TLS.")

DIRECTORY = Path("keys")
PRIVATE, PRIVATE_DIRECTORY = 0o600, 0o700
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
YEARS_10, YEAR = 3650.0, 365.0  # days
WIDE = 1000
"""Columns of a list that no terminal shows: a certificate is one line."""

RUN_DAYS = 30.0
"""For so long are the certificates of `fes run --secure` valid; they are deleted when the run ends."""

Directory = Annotated[Path, typer.Option("--keys", metavar="DIR", help="Where the certificates and keys are.")]
Days = Annotated[float, typer.Option(min=1e-3, max=YEARS_10, help="How long certificates are valid [days].")]
Hosts = Annotated[
    list[str] | None,
    typer.Option("--host", help="Another name or address of the world's machine; if none, issue keeps those it had."),
]


@guide.command(app, "keys init")
def init(
    robots: Annotated[int, typer.Option(min=0, max=MAX_ROBOTS, help="Certificates for robots 0 to N-1.")] = 0,
    host: Hosts = None,
    keys: Directory = DIRECTORY,
    days: Days = YEAR,
) -> int:
    """Make an authority, and certificates for the world, an observer, an operator, and robots."""
    if (keys / f"{AUTHORITY}.key").exists() or (keys / f"{AUTHORITY}.crt").exists():
        raise FesError(f"--keys {keys}: there is an authority already; fes keys issue adds to it")
    _check_directory(keys)
    hosts = _check_hosts(host)
    roles = [WORLD, OBSERVER, OPERATOR, *(identity.robot_role([robot]) for robot in range(robots))]
    authority = _authorities().found(YEARS_10)
    _write(keys, AUTHORITY, authority.pem)
    with progress.bar("certificates", len(roles)) as bar:
        for role in roles:
            _issue(authority, keys, [role], days, hosts)
            bar.advance()
    printing.line(f"{keys}: an authority and {len(roles)} certificates, valid for {days:g} days")
    return process.SUCCESS


@guide.command(app, "keys issue")
def issue(
    roles: Annotated[list[str], typer.Argument(help="world, observer, operator, robot-3, or the crew robot-0-4.")],
    host: Hosts = None,
    keys: Directory = DIRECTORY,
    days: Days = YEAR,
) -> int:
    """Issue certificates for roles, in place of those that there are."""
    checked = [identity.check_role(role) for role in roles]
    if host and WORLD not in checked:
        raise FesError(f"--host is for the world's certificate, not for that of {checked[0]}")
    _check_directory(keys)
    hosts = _check_hosts(host) or (_hosts(keys) if WORLD in checked else ())
    _issue(_restore(keys), keys, checked, days, hosts)
    printing.line(f"{keys}: {', '.join(checked)}, valid for {days:g} days")
    if WORLD in checked:
        printing.line(f"the world serves as {', '.join(_hosts(keys))}")
    return process.SUCCESS


@guide.command(app, "keys list")
def show(keys: Directory = DIRECTORY) -> int:
    """List certificates: role, serial number, end of validity, SHA-256 fingerprint, and for which hosts."""
    found = sorted(keys.glob("*.crt"), key=lambda path: [(len(part), part) for part in path.stem.split("-")])
    if not found:
        raise FesError(f"--keys {keys}: there are no certificates; fes keys init makes some")
    table = Table(
        "role", "serial", "valid until (UTC)", "SHA-256 of the certificate", "hosts", box=None, pad_edge=False
    )
    for path in found:
        try:
            table.add_row(*map(printing.cell, _authorities().describe(path.stem, path.read_bytes())))
        except ValueError:
            raise FesError(f"{path}: not a certificate") from None
    screen = printing.console()
    if not printing.is_screen(screen):
        screen.width = WIDE
    screen.print(table)
    return process.SUCCESS


@guide.command(app, "keys rules")
def rules(
    robots: Annotated[int, typer.Option(min=1, max=MAX_ROBOTS, help="Robots 0 to N-1 may take part.")],
    run: Annotated[str, typer.Option(help="Name of the run.")] = DEFAULT_RUN,
    listen: Annotated[str, typer.Option(help="Where the router listens.")] = "tls/0.0.0.0:7447",
    connect: Annotated[list[str] | None, typer.Option(help="Another router to link to.")] = None,
    keys: Directory = DIRECTORY,
) -> int:
    """Print the configuration of a Zenoh router of your own (zenohd -c FILE): TLS, and who may say and hear what."""
    certificate = identity.security(keys, WORLD)
    control = access.control(check_run(run), robots, identity.crews(keys), world=True)
    ends = Endpoints("router", tuple(connect or ()), (listen,), security={**certificate, **control})
    settings = {**ends.house_rules(), "connect/timeout_ms": -1}  # it waits for other routers for ever
    print(strict_json.dumps(_nested(settings), indent=2))
    return process.SUCCESS


def _nested(settings: Mapping[str, object]) -> dict[str, object]:
    """Settings by Zenoh's key, as its file has them."""
    found: dict[str, object] = {}
    for key, value in settings.items():
        *path, last = key.split("/")
        inner: Any = found
        for part in path:
            inner = inner.setdefault(part, {})
        inner[last] = value
    return found


@contextlib.contextmanager
def of_a_run(directory: Path, groups: Iterable[str]) -> Iterator[Path]:
    """Certificates for one run, in its directory: deleted when it ends, also where a second signal ends this process.

    Its authority's key is never written.
    """
    where = (directory / stale_keys.KEYS).resolve()
    authority = _authorities().found(RUN_DAYS)
    where.mkdir(mode=PRIVATE_DIRECTORY)

    def delete() -> None:
        shutil.rmtree(where, ignore_errors=True)

    try:
        with signals.if_forced(delete), stale_keys.marked(where):
            _write(where, AUTHORITY, authority.pem, with_key=False)
            _issue(authority, where, [WORLD, OBSERVER, OPERATOR, *(f"robot-{ids}" for ids in groups)], RUN_DAYS)
            yield where
    finally:
        delete()


def _issue(
    authority: "Authority", directory: Path, roles: list[str], days: float, hosts: tuple[str, ...] = ()
) -> None:
    for role in roles:
        _write(directory, role, _authorities().issue(authority, role, days, hosts))


def _restore(directory: Path) -> "Authority":
    """The authority in a directory; raises FesError."""
    authorities, where = _authorities(), directory / AUTHORITY
    key = where.with_suffix(".key")
    if not key.is_file():
        raise FesError(f"--keys {directory}: there is no authority; fes keys init makes one")
    identity.warn_if_open(key)
    pem = authorities.Issued(where.with_suffix(".crt").read_bytes(), key.read_bytes())
    try:
        authority: Authority = authorities.restore(pem)
    except (ValueError, TypeError):
        raise FesError(f"--keys {directory}: ca.crt or ca.key is none") from None
    if authority.key.public_key() != authority.certificate.public_key():
        raise FesError(f"{key}: is not the key of {AUTHORITY}.crt")
    return authority


def _check_hosts(hosts: list[str] | None) -> tuple[str, ...]:
    """The names of the world's machine that were asked for; raises FesError."""
    return tuple(_authorities().check_host(host) for host in hosts or ())


def _hosts(directory: Path) -> tuple[str, ...]:
    """The names of the world's machine in the certificate that there is; raises FesError."""
    where = directory / f"{WORLD}.crt"
    try:
        found: tuple[str, ...] = _authorities().hosts_of(where.read_bytes()) if where.exists() else ()
    except ValueError:
        raise FesError(f"{where}: not a certificate, so its names cannot be kept: say them with --host") from None
    return found


def _check_directory(directory: Path) -> None:
    """Raises FesError if others can write to a directory: they could put keys of their own in the place of ours."""
    mode = stat.S_IMODE(directory.stat().st_mode) if directory.exists() else 0
    if mode & _OTHERS_WRITE:
        raise FesError(f"--keys {directory}: others can write to it (mode {mode:04o}): chmod 700 {directory}")


def _write(directory: Path, name: str, issued: "Issued", *, with_key: bool = True) -> None:
    """Write a certificate and its key, which nobody but its owner may read, in one step each."""
    directory.mkdir(mode=PRIVATE_DIRECTORY, parents=True, exist_ok=True)
    contents = {f"{name}.key": issued.key, f"{name}.crt": issued.certificate}
    for file in contents if with_key else [f"{name}.crt"]:
        temporary = directory / f".{file}-{os.getpid()}"
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, PRIVATE)
        with os.fdopen(handle, "wb") as stream:
            stream.write(contents[file])
        os.replace(temporary, directory / file)


def _authorities() -> ModuleType:
    """What needs the extra; raises FesError without it."""
    try:
        from console.keys import certificates
    except ImportError:
        raise identity.missing_extra() from None
    return certificates
