"""Run directories, with the scenario, the summary and the log of a run, and the logs of its processes."""

import contextlib
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from console.keys import stale_keys
from fes.errors import FesError, Stopped, reason
from fes.protocol import keys
from fes.recording.layout import NAME
from fes.system import files, signals, strict_json
from fes.transport import addresses
from fes.transport.endpoints import DEFAULT_ENDPOINT, Endpoints, default_endpoint
from fes.transport.identity import security
from world.execution.checkpoint import FOLDER, has_checkpoint

ROOT = Path("runs")
LATEST = "latest"
ENDPOINT = "endpoint.json"
"""Name of the file with the address of a running run."""

SUMMARY = "summary.json"
SCENARIO = ("scenario.toml", ".scenario.toml")
FILES = {*SCENARIO, SUMMARY, f".{SUMMARY}", NAME, ENDPOINT}
"""Names of the files that a run writes, beside the logs of its processes."""
FOLDERS = {FOLDER, stale_keys.KEYS}
"""Names of the folders that a run writes."""


@dataclass(frozen=True)
class Address:
    """The address at which a run can be watched."""

    endpoint: str
    run: str
    pid: int = 0
    """Id of the process that withdraws the address when the run is over; 0 if it is not withdrawn."""
    keys: str | None = None
    """Folder of the certificates, if the run speaks TLS."""

    def __post_init__(self) -> None:
        """Raise TypeError for values that a run never announces, since any program may have written the file."""
        texts = (self.endpoint, self.run, self.keys or "")
        is_pid = type(self.pid) is int and 0 <= self.pid < 1 << 31  # True is an int too
        if not is_pid or not all(isinstance(text, str) for text in texts):
            raise TypeError("an address is an endpoint, a run, a process and a directory")


@dataclass(frozen=True)
class Client:
    """A program that connects to a run for a person."""

    role: str
    """Role of the certificate that it presents to a secured run."""
    keys: Path | None
    """Folder of that certificate; None for the folder that the run announces."""
    run: str
    timeout: float
    """Longest time to connect [s]."""


@contextlib.contextmanager
def created(scenario: str, out: Path | None) -> Iterator["RunDirectory"]:
    """A new run directory: `out`, or runs/<scenario>-<n> with runs/latest pointing at it; raises FesError.

    It is removed if a signal ends the block before the first tick, or an error before the run writes a file. A
    Stopped raised in the block names the directory with the partial results.
    """
    directory = None
    try:
        with signals.blocked():  # a signal meanwhile is delivered once there is a directory to discard
            directory = RunDirectory.create(scenario, out)
        yield directory
    except Stopped as stopped:
        if directory is None:
            raise
        if has_checkpoint(directory.path) or (directory.path / SUMMARY).exists():
            raise Stopped(f"{stopped}; the results so far are in {directory.path}") from None
        directory.discard()
        raise
    except (FesError, OSError):
        if directory is not None and directory.is_bare:
            directory.discard()
        raise


@dataclass(frozen=True)
class RunDirectory:
    """The directory of one run, which can be removed without a trace."""

    path: Path
    parents: tuple[Path, ...]
    """The folders created for it, itself included, the innermost first."""
    latest: Path | None = None
    """The previous target of runs/latest."""

    @classmethod
    def create(cls, scenario: str, out: Path | None) -> Self:
        """A new directory, as `created` describes; raises FesError."""
        try:
            if out is not None:
                parents = tuple(folder for folder in (out, *out.parents) if not folder.exists())
                out.mkdir(parents=True, exist_ok=True)
                if any(out.iterdir()):
                    raise FesError(f"--out {out}: the directory is not empty{stale_keys.remark(out)}")
                return cls(out, parents)
            parents = () if ROOT.exists() else (ROOT,)
            ROOT.mkdir(exist_ok=True)
            number = 1
            while True:
                directory = ROOT / f"{scenario}-{number}"
                with contextlib.suppress(FileExistsError):
                    directory.mkdir()
                    break
                number += 1
            return cls(directory, (directory, *parents), _point_at(directory))
        except OSError as error:
            raise FesError(f"cannot create a run directory: {reason(error)}") from None

    @property
    def is_bare(self) -> bool:
        """True if it holds only its scenario."""
        with contextlib.suppress(OSError):
            return all(path.name in SCENARIO for path in self.path.iterdir())
        return False

    def discard(self) -> None:
        """Remove it with the files that a run writes, and point runs/latest at its previous target."""
        with signals.blocked(), contextlib.suppress(OSError):
            for path in list(self.path.iterdir()):
                if path.name in FOLDERS:
                    shutil.rmtree(path, ignore_errors=True)
                elif path.name in FILES or path.suffix == ".log":
                    path.unlink(missing_ok=True)
            if self.parents:
                self.path.rmdir()
            latest = ROOT / LATEST
            if latest.is_symlink() and latest.readlink() == Path(self.path.name) and not latest.exists():
                latest.unlink()
                if self.latest is not None and (ROOT / self.latest).exists():
                    _point_at(self.latest)
            for folder in self.parents[1:]:
                folder.rmdir()


def announce(directory: Path, address: Address) -> None:
    """Write the address of a run into its directory."""
    (directory / ENDPOINT).write_text(strict_json.dumps(vars(address)) + "\n", encoding="utf-8")


def withdraw(directory: Path) -> None:
    """Remove the address of a run that can no longer be watched."""
    (directory / ENDPOINT).unlink(missing_ok=True)


def announced(run: str) -> tuple[Path, Address] | None:
    """The newest announcement of a running run `run` in this folder: its file and its address; None without one.

    A run in one loop announces none.
    """
    paths = (path for path in ROOT.glob(f"*/{ENDPOINT}") if not path.parent.is_symlink())
    for path in sorted(paths, key=_modification_time, reverse=True):
        with contextlib.suppress(FesError, TypeError, OverflowError):
            address = _address(files.read_table(path))
            if address.run == run and _is_running(address.pid):
                return path, address
    return None


def _address(table: dict[str, Any]) -> Address:
    """The address in an endpoint.json; raises TypeError or FesError for content that `announce` never writes."""
    address = Address(**table)
    addresses.check(address.endpoint, listening=False)
    return address


def find(run: str) -> Address:
    """The address of a run that is announced in this folder, or else the default endpoint."""
    announcement = announced(run)
    return announcement[1] if announcement else Address(DEFAULT_ENDPOINT, run)


def _modification_time(path: Path) -> float:
    """Time at which a file was written [s since 1970]; 0 if it was removed just now."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _is_running(pid: int) -> bool:
    """True if the process that announced a run still runs. A killed process leaves its announcement behind."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, 0)
        return True
    return False


def endpoints(client: Client, connect: list[str] | None, config: Path | None, cfg: list[str] | None) -> Endpoints:
    """Endpoints of a client: those given, or else that of the latest run started in this folder."""
    address = find(keys.check_run(client.run))
    if connect or (client.keys and not address.keys):
        address = Address(default_endpoint(secure=client.keys is not None), client.run)
    directory = client.keys or (Path(address.keys) if address.keys else None)
    targets = tuple(connect or (address.endpoint,))
    by_default = frozenset() if connect else frozenset({"connect/endpoints"})
    own = security(directory, client.role)
    return Endpoints("client", targets, (), config, tuple(cfg or ()), client.timeout, by_default, own)


def _point_at(directory: Path) -> Path | None:
    """Point runs/latest at the directory, atomically; returns its previous target."""
    temporary, latest = ROOT / f".{LATEST}-{os.getpid()}", ROOT / LATEST
    before = latest.readlink() if latest.is_symlink() else None
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(directory.name)
    os.replace(temporary, latest)
    return before
