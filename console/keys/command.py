"""fes keys: certificates in a folder, and those that `fes run --secure` makes for one run."""

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

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Issue and list certificates for runs over TLS.",
)

DIRECTORY = Path("keys")
PRIVATE, PRIVATE_DIRECTORY = 0o600, 0o700
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
YEARS_10, YEAR = 3650.0, 365.0  # days
WIDE = 1000
"""Width of a list that is not shown in a terminal [columns]: each certificate takes one line."""

RUN_DAYS = 30.0
"""Validity of the certificates of `fes run --secure` [days]; they are deleted when the run ends."""

Directory = Annotated[Path, typer.Option("--keys", metavar="DIR", help="Folder of the certificates and keys.")]
Days = Annotated[float, typer.Option(min=1e-3, max=YEARS_10, help="Validity of the certificates [days].")]
Hosts = Annotated[
    list[str] | None,
    typer.Option(
        "--host", help="Further name or address of the world's machine (default of issue: those in its certificate)."
    ),
]


@guide.command(app, "keys init")
def init(
    robots: Annotated[
        int, typer.Option(min=0, max=MAX_ROBOTS, metavar="N", help="Also issue certificates for robots 0 to N-1.")
    ] = 0,
    host: Hosts = None,
    keys: Directory = DIRECTORY,
    days: Days = YEAR,
) -> int:
    """Create an authority, and certificates for the world, an observer, an operator, and robots."""
    if (keys / f"{AUTHORITY}.key").exists() or (keys / f"{AUTHORITY}.crt").exists():
        raise FesError(f"--keys {keys}: the folder has an authority already; fes keys issue adds certificates to it")
    _check_directory(keys)
    hosts = _check_hosts(host)
    roles = [WORLD, OBSERVER, OPERATOR, *(identity.robot_role([robot]) for robot in range(robots))]
    authority = _authorities().create(YEARS_10)
    _write(keys, AUTHORITY, authority.pem)
    with progress.shown("issuing", len(roles), "certificates") as watch:
        for number, role in enumerate(roles, 1):
            _issue(authority, keys, [role], days, hosts)
            watch(number)
    printing.line(f"{keys}: an authority and {len(roles)} certificates, valid for {days:g} days")
    return process.SUCCESS


@guide.command(app, "keys issue")
def issue(
    roles: Annotated[
        list[str],
        typer.Argument(help="Roles: world, observer, operator, robot-3, or robot-0-4 for the crew of robots 0 to 4."),
    ],
    host: Hosts = None,
    keys: Directory = DIRECTORY,
    days: Days = YEAR,
) -> int:
    """Issue certificates for roles; existing ones are replaced."""
    checked = [identity.check_role(role) for role in roles]
    if host and WORLD not in checked:
        raise FesError(f"--host is only for the certificate of the world, not for that of {checked[0]}")
    _check_directory(keys)
    hosts = _check_hosts(host) or (_hosts(keys) if WORLD in checked else ())
    _issue(_restore(keys), keys, checked, days, hosts)
    printing.line(f"{keys}: {', '.join(checked)}, valid for {days:g} days")
    if WORLD in checked:
        printing.line(f"names of the world: {', '.join(_hosts(keys))}")
    return process.SUCCESS


@guide.command(app, "keys list")
def show(keys: Directory = DIRECTORY) -> int:
    """List certificates: role, serial number, end of validity, SHA-256 fingerprint and hosts."""
    paths = sorted(keys.glob("*.crt"), key=lambda path: [(len(part), part) for part in path.stem.split("-")])
    if not paths:
        raise FesError(f"--keys {keys}: no certificates in this folder; fes keys init creates some")
    table = Table(
        "role", "serial", "valid until (UTC)", "SHA-256 of the certificate", "hosts", box=None, pad_edge=False
    )
    for path in paths:
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
    robots: Annotated[int, typer.Option(min=1, max=MAX_ROBOTS, help="Number of robots that may take part.")],
    run: Annotated[str, typer.Option(metavar="NAME", help="Name of the run.")] = DEFAULT_RUN,
    listen: Annotated[str, typer.Option(help="Endpoint on which the router listens.")] = "tls/0.0.0.0:7447",
    connect: Annotated[list[str] | None, typer.Option(help="Endpoint of another router to connect to.")] = None,
    keys: Directory = DIRECTORY,
) -> int:
    """Print the configuration of a separate Zenoh router (zenohd -c FILE): TLS, and the access rules of each role."""
    certificate = identity.security(keys, WORLD)
    control = access.control(check_run(run), robots, identity.crews(keys), world=True)
    ends = Endpoints("router", tuple(connect or ()), (listen,), security={**certificate, **control})
    settings = {**ends.house_rules(), "connect/timeout_ms": -1}  # the router never stops trying to connect
    print(strict_json.dumps(_nested(settings), indent=2))
    return process.SUCCESS


def _nested(settings: Mapping[str, object]) -> dict[str, object]:
    """Settings by Zenoh's keys, as the nested tables of its configuration file."""
    tables: dict[str, object] = {}
    for key, value in settings.items():
        *path, last = key.split("/")
        inner: Any = tables
        for part in path:
            inner = inner.setdefault(part, {})
        inner[last] = value
    return tables


@contextlib.contextmanager
def for_run(directory: Path, groups: Iterable[str]) -> Iterator[Path]:
    """Certificates for one run, in its directory, until the block ends or a second signal ends this process.

    The private key of their authority is never written.
    """
    folder = (directory / stale_keys.KEYS).resolve()
    authority = _authorities().create(RUN_DAYS)
    folder.mkdir(mode=PRIVATE_DIRECTORY)

    def delete() -> None:
        shutil.rmtree(folder, ignore_errors=True)

    try:
        with signals.if_forced(delete), stale_keys.marked(folder):
            _write(folder, AUTHORITY, authority.pem, with_key=False)
            _issue(authority, folder, [WORLD, OBSERVER, OPERATOR, *(f"robot-{ids}" for ids in groups)], RUN_DAYS)
            yield folder
    finally:
        delete()


def _issue(
    authority: "Authority", directory: Path, roles: list[str], days: float, hosts: tuple[str, ...] = ()
) -> None:
    for role in roles:
        _write(directory, role, _authorities().issue(authority, role, days, hosts))


def _restore(directory: Path) -> "Authority":
    """The authority in a folder; raises FesError."""
    authorities, stem = _authorities(), directory / AUTHORITY
    key = stem.with_suffix(".key")
    if not key.is_file():
        raise FesError(f"--keys {directory}: no authority in this folder; fes keys init creates one")
    identity.warn_if_open(key)
    pem = authorities.Issued(stem.with_suffix(".crt").read_bytes(), key.read_bytes())
    try:
        authority: Authority = authorities.restore(pem)
    except (ValueError, TypeError):
        raise FesError(
            f"--keys {directory}: ca.crt or ca.key is not PEM of an elliptic-curve key without a password"
        ) from None
    if authority.key.public_key() != authority.certificate.public_key():
        raise FesError(f"{key}: is not the key of {AUTHORITY}.crt")
    return authority


def _check_hosts(hosts: list[str] | None) -> tuple[str, ...]:
    """The names of the world's machine in --host; raises FesError."""
    return tuple(_authorities().check_host(host) for host in hosts or ())


def _hosts(directory: Path) -> tuple[str, ...]:
    """The names of the world's machine in its present certificate, none without one; raises FesError."""
    path = directory / f"{WORLD}.crt"
    try:
        hosts: tuple[str, ...] = _authorities().hosts_of(path.read_bytes()) if path.exists() else ()
    except ValueError:
        raise FesError(f"{path}: not a certificate, so its names are unknown: name them with --host") from None
    return hosts


def _check_directory(directory: Path) -> None:
    """Raise FesError if other users can write to a folder, and so replace its keys."""
    mode = stat.S_IMODE(directory.stat().st_mode) if directory.exists() else 0
    if mode & _OTHERS_WRITE:
        raise FesError(f"--keys {directory}: other users can write to it (mode {mode:04o}): chmod 700 {directory}")


def _write(directory: Path, name: str, issued: "Issued", *, with_key: bool = True) -> None:
    """Write a certificate and its private key, which only its owner may read, each atomically."""
    directory.mkdir(mode=PRIVATE_DIRECTORY, parents=True, exist_ok=True)
    contents = {f"{name}.key": issued.key, f"{name}.crt": issued.certificate}
    for file in contents if with_key else [f"{name}.crt"]:
        temporary = directory / f".{file}-{os.getpid()}"
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, PRIVATE)
        with os.fdopen(handle, "wb") as stream:
            stream.write(contents[file])
        os.replace(temporary, directory / file)


def _authorities() -> ModuleType:
    """The module `certificates`, which needs an extra; raises FesError without it."""
    try:
        from console.keys import certificates
    except ImportError:
        raise identity.missing_extra() from None
    return certificates
