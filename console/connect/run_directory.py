"""Run directories: where a run leaves its scenario, its summary and its children's logs."""

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
"""Where a run directory says, while its run goes on, where it can be watched."""

SUMMARY = "summary.json"
SCENARIO = ("scenario.toml", ".scenario.toml")
FILES = {*SCENARIO, SUMMARY, f".{SUMMARY}", NAME, ENDPOINT}
"""Files that a run writes, beside the logs of its children."""
FOLDERS = {FOLDER, stale_keys.KEYS}


@dataclass(frozen=True)
class Address:
    """Where a run can be watched."""

    endpoint: str
    run: str
    pid: int = 0
    """Of the process that withdraws this when the run is over; 0 if nobody does."""
    keys: str | None = None
    """Where the certificates are, if it can be watched only with one."""

    def __post_init__(self) -> None:
        """Raise TypeError for values that no run announces: any program may have written the file."""
        texts = (self.endpoint, self.run, self.keys or "")
        is_pid = type(self.pid) is int and 0 <= self.pid < 1 << 31  # True is an int, and not a process
        if not is_pid or not all(isinstance(text, str) for text in texts):
            raise TypeError("an address is an endpoint, a run, a process and a directory")


@dataclass(frozen=True)
class Visitor:
    """A person's tool that wants to reach a run."""

    role: str
    """Whose certificate it shows, where one is asked for."""
    keys: Path | None
    """Where that certificate is; None to look for it where the run was started."""
    run: str
    timeout: float
    """How long to try [s]."""


@contextlib.contextmanager
def made(scenario: str, out: Path | None) -> Iterator["RunDirectory"]:
    """A new run directory: `out`, or runs/<scenario>-<n> with runs/latest pointing at it; raises FesError.

    It is removed again if a signal ends the block before a tick was reached, or an error before anything was written.
    A Stopped that leaves the block names the directory that holds what was reached.
    """
    directory = None
    try:
        with signals.blocked():  # one that comes meanwhile is delivered when there is something to discard
            directory = RunDirectory.create(scenario, out)
        yield directory
    except Stopped as stopped:
        if directory is None:
            raise
        if has_checkpoint(directory.path) or (directory.path / SUMMARY).exists():
            raise Stopped(f"{stopped}; what was reached is in {directory.path}") from None
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
    """The folders that were made for it, itself included, the innermost first."""
    latest: Path | None = None
    """The previous target of runs/latest."""

    @classmethod
    def create(cls, scenario: str, out: Path | None) -> Self:
        """A new one, as `made` says."""
        try:
            if out is not None:
                parents = tuple(folder for folder in (out, *out.parents) if not folder.exists())
                out.mkdir(parents=True, exist_ok=True)
                if any(out.iterdir()):
                    raise FesError(f"--out {out}: the directory is not empty{stale_keys.named(out)}")
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
        """True if it holds nothing but its scenario."""
        with contextlib.suppress(OSError):
            return all(path.name in SCENARIO for path in self.path.iterdir())
        return False

    def discard(self) -> None:
        """Remove it, with what a run writes and nothing else; runs/latest points where it did before."""
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
    """Say in the run directory where the run can be watched."""
    (directory / ENDPOINT).write_text(strict_json.dumps(vars(address)) + "\n", encoding="utf-8")


def withdraw(directory: Path) -> None:
    """The run cannot be watched any more."""
    (directory / ENDPOINT).unlink(missing_ok=True)


def announced(run: str) -> tuple[Path, Address] | None:
    """The run of this folder that was started last of those that go on and can be watched (one in process cannot):
    where it says so, and what it says."""
    said = (path for path in ROOT.glob(f"*/{ENDPOINT}") if not path.parent.is_symlink())
    for path in sorted(said, key=_written, reverse=True):
        with contextlib.suppress(FesError, TypeError, OverflowError):
            found = _address(files.read_table(path))
            if found.run == run and _lives(found.pid):
                return path, found
    return None


def _address(told: dict[str, Any]) -> Address:
    """The address in an endpoint.json; raises TypeError or FesError for content that `announce` never writes."""
    found = Address(**told)
    addresses.check(found.endpoint, listening=False)
    return found


def find(run: str) -> Address:
    """Where to look without being told: the run that is announced in this folder, else the default endpoint."""
    found = announced(run)
    return found[1] if found else Address(DEFAULT_ENDPOINT, run)


def _written(path: Path) -> float:
    """When it was written [s]; long ago where it was withdrawn just now."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _lives(pid: int) -> bool:
    """Whether the process that announced a run is still there: one that was killed withdrew nothing."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, 0)
        return True
    return False


def reach(who: Visitor, connect: list[str] | None, config: Path | None, cfg: list[str] | None) -> Endpoints:
    """The way to a run that goes on: the endpoints given, else the latest run started in this folder."""
    found = find(keys.check_run(who.run))
    if connect or (who.keys and not found.keys):
        found = Address(default_endpoint(secure=who.keys is not None), who.run)
    directory = who.keys or (Path(found.keys) if found.keys else None)
    where = tuple(connect or (found.endpoint,))
    unasked = frozenset() if connect else frozenset({"connect/endpoints"})
    own = security(directory, who.role)
    return Endpoints("client", where, (), config, tuple(cfg or ()), who.timeout, unasked, own)


def _point_at(directory: Path) -> Path | None:
    """Point runs/latest at the directory, in one step; returns its previous target."""
    temporary, latest = ROOT / f".{LATEST}-{os.getpid()}", ROOT / LATEST
    before = latest.readlink() if latest.is_symlink() else None
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(directory.name)
    os.replace(temporary, latest)
    return before
