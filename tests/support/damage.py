"""Random damage to every stored file of a run: `python -m tests.support.damage --changes 2000`.

A checkpoint of a killed run is resumed with one of its files changed, a log is executed again, a sweep is continued.
Each must end in one line, or with the digest, summary, log and rows of the unchanged files.
"""

import argparse
import copy
import json
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

from console.replay import command as replay_command
from console.replay import log
from console.sweep import design, ledger, work
from console.sweep.work import Done
from fes.errors import FesError
from fes.recording.layout import NAME
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.teams import Team
from world.config.scenario import Scenario
from world.execution import resume
from world.execution.checkpoint import CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.metrics import summary

SAVED, FLUSHED, KILLED = 0.4, 0.6, 0.7
"""Times of the checkpoint, of a written chunk of the log, and of the world's death, as parts of the run."""

LINE, SAME, BEHIND, SILENT, TRACEBACK = "one line", "as undisturbed", "behind its robots", "silent", "traceback"

Outcome = tuple[str, str]
"""Kind of outcome, and its message."""


def flip(random: Random, content: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 8))):
        changed[random.randrange(len(content))] ^= 1 << random.randrange(8)
    return bytes(changed)


def cut(random: Random, content: bytes) -> bytes:
    return content[: random.randrange(len(content))]


def zero(random: Random, content: bytes) -> bytes:
    place, size = random.randrange(len(content)), random.choice((1, 4, 64, 512))
    return (content[:place] + bytes(size) + content[place + size :])[: len(content)]


HOW: list[Callable[[Random, bytes], bytes]] = [flip, cut, zero]


def change(random: Random, content: bytes, how: Callable[[Random, bytes], bytes]) -> bytes:
    """Bytes that differ from the original."""
    while (changed := how(random, content)) == content:
        pass
    return changed


def comparable(values: dict[str, Any]) -> str:
    """A summary without its wall-clock figures."""
    return json.dumps({name: value for name, value in values.items() if name not in work.WALL_CLOCK})


class StoredRun:
    """A killed run, and its results without the kill."""

    def __init__(self, where: Path, scenario: Scenario) -> None:
        self.where, self.scenario = where, scenario
        self.killed, self.work = where / "killed", where / "work"
        folder = where / "whole"
        folder.mkdir()
        saved, flushed, killed = (int(part * scenario.ticks) for part in (SAVED, FLUSHED, KILLED))
        self.answered = killed - 1
        team, self.teams = Team(scenario), list[Team]()
        with Recorder(folder / NAME, scenario, "test", "processes") as recorder:
            checkpoints = CheckpointWriter(folder, 1e9, "test", "main")
            run = Run(scenario, recorder, checkpoints.note)
            checkpoints.begin(run)
            for tick in range(scenario.ticks):
                if tick == saved:
                    checkpoints.save(run, {}, 0.1, at_once=True)
                if tick == flushed:
                    recorder.pause()
                if tick == killed:
                    shutil.copytree(folder, self.killed)
                self.teams.append(copy.copy(team))
                team.step(run)
            checkpoints.discard(run)
            self.summary = summary.summarize(run.metrics, "test", "processes", 1.0)
            recorder.conclude(self.summary)
        self.log = folder / NAME
        self.ticks = list(log.load(self.log).ticks())

    @property
    def files(self) -> list[Path]:
        """Number of ticks of the killed run."""
        return sorted(path for path in self.killed.rglob("*") if path.is_file())

    def resumed(self, name: str, changed: bytes) -> Outcome:
        """Outcome of a resumption with one of the files changed."""
        shutil.rmtree(self.work, ignore_errors=True)
        shutil.copytree(self.killed, self.work)
        (self.work / name).write_bytes(changed)
        saved = resume.load(self.work)
        recorder = resume.recorder(self.work, saved)
        assert recorder is not None
        with recorder:
            run, checkpoints, _ = resume.run(self.work, saved, recorder, 1e9)
            first = run.state.tick
            team = copy.copy(self.teams[first])
            while not run.is_over:
                team.step(run)
            reached = summary.summarize(run.metrics, "test", "processes", 1.0)
            recorder.conclude(reached)
            checkpoints.discard(run)
        if comparable(reached) != comparable(self.summary):
            return SILENT, f"digest {reached['digest']}"
        if self._ticks_of(self.work / NAME) < len(self.ticks):
            return SILENT, "a shorter log"
        # Living robots repeat at most their words of one tick back (agents.runtime.tick_source), and else end with a
        # line.
        return (SAME, "") if first >= self.answered else (BEHIND, f"tick {first}")

    def _ticks_of(self, path: Path) -> int:
        """Number of ticks in a log, which must all equal those of an undisturbed run."""
        ticks = list(log.load(path).ticks())
        assert all(first.payloads == second.payloads for first, second in zip(ticks, self.ticks, strict=False)), (
            "other messages"
        )
        return len(ticks)

    def executed_again(self, name: str, changed: bytes) -> Outcome:
        """Outcome of executing a changed log again."""
        path = self.where / "changed.mcap"
        path.write_bytes(changed)
        recorded = log.load(path)
        reached = replay_command.rerun(recorded)
        self._ticks_of(path)
        if recorded.complaint is not None:
            return LINE, recorded.complaint
        return (SAME, "") if comparable(reached) == comparable(self.summary) else (SILENT, f"{reached['digest']}")


class Sweep:
    """A finished sweep of three runs."""

    def __init__(self, where: Path) -> None:
        self.where = where
        self.planned = design.plan(CONFIGS / "pair.toml", [], "0:3", ["run.duration=0.2"])
        with ledger.opened(where, self.planned) as book:
            for batch in work.batches("pair", self.planned.runs, 1):
                book.add(work.carry_out(batch))
            self.done: dict[str, Done] = dict(book.done)
        self.contents = {path.name: path.read_bytes() for path in where.iterdir()}

    def resumed(self, name: str, changed: bytes) -> Outcome:
        """Outcome of continuing the sweep; missing runs are repeated."""
        for path, content in self.contents.items():
            (self.where / path).write_bytes(changed if path == name else content)
        with ledger.opened(self.where, self.planned) as book:
            same = all(self.done.get(key) == done for key, done in book.done.items())
        return (SAME, "") if same else (SILENT, "other rows")


def outcome(what: Callable[[str, bytes], Outcome], name: str, changed: bytes) -> Outcome:
    """Outcome of a call, errors of any kind included."""
    try:
        return what(name, changed)
    except FesError as error:
        return (LINE, str(error)) if "\n" not in str(error) else (TRACEBACK, f"several lines: {error}")
    except Exception as error:
        return TRACEBACK, repr(error)


def trials(where: Path, scenario: Scenario) -> dict[str, tuple[bytes, str, Callable[[str, bytes], Outcome]]]:
    """For each file that is changed: its content, its name, and the use of the changed file."""
    run, sweep = StoredRun(where, scenario), Sweep(where / "sweep")
    saved = {str(path.relative_to(run.killed)): path.read_bytes() for path in run.files}
    return {
        **{name: (content, name, run.resumed) for name, content in saved.items()},
        "a whole log": (run.log.read_bytes(), "", run.executed_again),
        **{name: (content, name, sweep.resumed) for name, content in sweep.contents.items()},
    }


def damage(where: Path, scenario: Scenario, changes: int, seed: int) -> dict[str, Counter[tuple[str, str]]]:
    """Counts of each change and outcome per file; forbidden outcomes are printed."""
    results = dict[str, Counter[tuple[str, str]]]()
    for title, (content, name, probe) in trials(where, scenario).items():
        random, results[title] = Random(f"{seed} {title}"), Counter()
        for number in range(changes):
            how = HOW[number % len(HOW)]
            changed = change(random, content, how)
            kind, message = outcome(probe, name, changed)
            results[title][how.__name__, kind] += 1
            if kind in (SILENT, TRACEBACK):
                print(f"{title}, {how.__name__} {number}: {kind}: {message}")
    return results


def main() -> int:
    """Print a table; returns 1 if damage was silent or caused a traceback."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.damage", description=__doc__)
    parser.add_argument("--changes", type=int, default=2000, help="of each file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenario", default="pair.toml", help="of configs/")
    parser.add_argument("--duration", type=float, default=1.0, help="simulated [s]")
    flags = parser.parse_args()
    with tempfile.TemporaryDirectory() as where:
        results = damage(Path(where), load(flags.scenario, run__duration=flags.duration), flags.changes, flags.seed)
    kinds = (LINE, SAME, BEHIND, SILENT, TRACEBACK)
    print("".join(f"{title:>20}" for title in ("file", "change", *kinds)))
    for title, counts in results.items():
        for how in HOW:
            row = (counts[how.__name__, kind] for kind in kinds)
            print(f"{title:>20}{how.__name__:>20}" + "".join(f"{count:>20}" for count in row))
    with suppress(BrokenPipeError):
        sys.stdout.flush()
    return int(any(kind in (SILENT, TRACEBACK) for counts in results.values() for _, kind in counts))


if __name__ == "__main__":
    sys.exit(main())
