"""Run directories: where a run leaves its scenario, its summary and its children's logs."""

import contextlib
import json
import os
from dataclasses import dataclass
from pathlib import Path

from fes import files, keys
from fes.endpoints import DEFAULT_ENDPOINT, Endpoints, default_endpoint
from fes.errors import FesError, reason
from fes.identity import security

ROOT = Path("runs")
LATEST = "latest"
ENDPOINT = "endpoint.json"
"""Where a run directory says, while its run goes on, where it can be watched."""


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
        """Raise TypeError for what no run announces: anybody may have written the file."""
        texts = (self.endpoint, self.run, self.keys or "")
        if not all(isinstance(text, str) for text in texts) or not 0 <= self.pid < 1 << 31:
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


def create(scenario: str, out: Path | None) -> Path:
    """A new run directory: `out`, or runs/<scenario>-<n> with runs/latest pointing at it; raises FesError."""
    try:
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
            if any(out.iterdir()):
                raise FesError(f"--out {out}: the directory is not empty")
            return out
        ROOT.mkdir(exist_ok=True)
        number = 1
        while True:
            directory = ROOT / f"{scenario}-{number}"
            with contextlib.suppress(FileExistsError):
                directory.mkdir()
                break
            number += 1
        _point_at(directory)
        return directory
    except OSError as error:
        raise FesError(f"cannot create a run directory: {reason(error)}") from None


def announce(directory: Path, address: Address) -> None:
    """Say in the run directory where the run can be watched."""
    (directory / ENDPOINT).write_text(json.dumps(vars(address)) + "\n", encoding="utf-8")


def withdraw(directory: Path) -> None:
    """The run cannot be watched any more."""
    (directory / ENDPOINT).unlink(missing_ok=True)


def announced(run: str) -> tuple[Path, Address] | None:
    """The run of this folder that was started last of those that go on and can be watched (one in process cannot):
    where it says so, and what it says."""
    said = (path for path in ROOT.glob(f"*/{ENDPOINT}") if not path.parent.is_symlink())
    for path in sorted(said, key=_written, reverse=True):
        with contextlib.suppress(FesError, TypeError):
            found = Address(**files.read_table(path))
            if found.run == run and _lives(found.pid):
                return path, found
    return None


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


def _point_at(directory: Path) -> None:
    """Point runs/latest at the directory, in one step."""
    temporary = ROOT / f".{LATEST}-{os.getpid()}"
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(directory.name)
    os.replace(temporary, ROOT / LATEST)
