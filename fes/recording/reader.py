"""Logs of runs, read back; docs/reference/log.md describes their format.

The caller defines the type of a scenario: `load` takes the function that parses its tables.
"""

import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from mcap.records import Metadata

from fes.errors import FesError
from fes.recording import schemas, ticks
from fes.recording.layout import AT_ITS_END, NAME, SUMMARY
from fes.recording.records import Reader
from fes.recording.ticks import LoggedTick
from fes.system import fingerprint, strict_json


class RobotNumber(Protocol):
    """The robots of a scenario."""

    @property
    def number(self) -> int:
        """Number of robots."""


class Recorded(Protocol):
    """A scenario, as far as reading its log needs it."""

    @property
    def robots(self) -> RobotNumber:
        """The robots."""

    @property
    def ticks(self) -> int:
        """Number of ticks."""


S = TypeVar("S", bound=Recorded)


@dataclass(frozen=True)
class Log(Generic[S]):
    """A log; its ticks are read anew from the file each time."""

    path: Path
    name: str
    """Name of the scenario."""
    backend: str
    scenario: S
    summary: dict[str, Any] | None
    """Summary of the ticks that were run; None if the log has no end."""
    ended: str | None
    """Reason for the end of the run; None if the log has no end."""
    arithmetic: Mapping[str, str] = field(default_factory=fingerprint.table)
    """Arithmetic of the process that recorded it."""
    extensions: list[Any] = field(default_factory=list)
    """Evidence of each extension (`fes.extension.evidence`)."""
    fes_version: str | None = None
    """Version of fes that recorded it, if it is known."""
    version: int = schemas.VERSION
    """Version of the log's format."""

    def ticks(self) -> Iterator[LoggedTick]:
        """Its ticks, in order; of a log without an end the complete ones. Raises FesError."""
        count = 0
        try:
            for expected, tick in enumerate(ticks.read(self.path, self.scenario.robots.number, self.version)):
                if tick.number != expected:
                    raise FesError(f"{self.path}: after tick {expected - 1} comes tick {tick.number}")
                if expected >= self.scenario.ticks:
                    raise FesError(f"{self.path}: it continues after tick {expected - 1}, the last of its scenario")
                yield tick
                count = expected + 1
        except ticks.UNREADABLE as error:
            raise FesError(
                f"{self.path}: a message is not what its topic promises: {ticks.one_line(error)}"
            ) from None
        if self.summary is not None and count != self.summary.get("ticks"):
            raise FesError(f"{self.path}: {count} ticks are there, and its summary is of {self.summary.get('ticks')}")
        if self.ended == AT_ITS_END and count != self.scenario.ticks:
            raise FesError(f"{self.path}: {count} of {self.scenario.ticks} ticks are there, and it gives no reason")

    @property
    def origin(self) -> str:
        """Version of fes and arithmetic of the process that recorded it."""
        return fingerprint.origin(self.fes_version, self.arithmetic)

    @property
    def complaint(self) -> str | None:
        """Complaint about a log without an end; None if it has one."""
        if self.ended is not None:
            return None
        count = sum(1 for _ in self.ticks())
        of = f"{count} of {self.scenario.ticks} ticks are there"
        return f"{self.path} has no end, its run was killed or the file was cut: {of}"


def find(target: Path) -> Path | None:
    """The log at `target`, a file or a run directory; None for a run directory without a log."""
    if not target.is_dir():
        return target
    return target / NAME if (target / NAME).is_file() else None


def load(target: Path, parse: Callable[[dict[str, Any], str], S]) -> Log[S]:
    """A log with at least one tick, from a file or a run directory; raises FesError in one line.

    `parse` makes the scenario from its tables. Its second argument is the file, which its errors name.
    """
    path = find(target)
    if path is None:
        raise FesError(f"{target} has no {NAME}: the run was not recorded")
    header = _scenario(path)
    version = header.get("log")
    if type(version) is not int or not schemas.READABLE <= version <= schemas.VERSION:
        readable = f"versions {schemas.READABLE} and {schemas.VERSION}"
        raise FesError(f"{path} is a log of version {version!r:.20}; this fes reads {readable}")
    ended = _metadata(path)
    try:
        summary = strict_json.loads(ended["summary"]) if ended and "summary" in ended else None
        if summary is not None and not isinstance(summary, dict):
            raise TypeError("its summary is not a table")
        scenario = parse(tomllib.loads(header["scenario"]), str(path))
        fingerprint.text(header["arithmetic"])  # raises one of these errors if it is invalid
        if not all(isinstance(header[key], str) for key in ("name", "backend")):
            raise TypeError("its name and backend are texts")
        how = ended["ended"] if ended else None
        names = header["name"], header["backend"]
        by = header.get("versions", {}).get("fes")
        log = Log(path, *names, scenario, summary, how, header["arithmetic"], header["extensions"], by, version)
    except ticks.UNREADABLE as error:
        raise FesError(f"{path}: what it says of its run cannot be read: {ticks.one_line(error)}") from None
    if next(log.ticks(), None) is None:
        raise FesError(log.complaint or f"{path}: the run was over before its first tick")
    return log


def _scenario(path: Path) -> dict[str, Any]:
    """Scenario and versions of the run: the first message of the log."""
    with suppress(ValueError, RecursionError):
        for topic, message in ticks.messages(path):
            if topic == "/scenario":
                header = ticks.parsed(message.data)
                if isinstance(header, dict):
                    return header
            break
    raise FesError(f"{path} is not a log of a run: it does not begin with its scenario")


def _metadata(path: Path) -> dict[str, str] | None:
    """The metadata written when the log was closed; None if it was not. Raises FesError for a damaged log."""
    reader, metadata = Reader(path), None
    for block in reader:
        if isinstance(block.record, Metadata) and block.record.name == SUMMARY:
            metadata = block.record.metadata
    return metadata if reader.has_end else None
