"""Runs that are gone on with from a checkpoint: after every tick of one loop, and not from a damaged one."""

import os
import pickle
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents import assembly, crew
from console import log, replay
from fes import messages
from fes.arrays import Bools
from fes.errors import FesError
from fes.sensing import silence
from tests.loop import load
from world import checkpoint, journal, resume, simulation
from world.checkpoint import FOLDER, Keeper
from world.course import Course
from world.process import main
from world.recorder import NAME, Recorder
from world.scenario import Scenario, agent_config

MACHINE = ("backend", "wall_s", "ticks_per_s", "real_time_factor")
"""What of a summary is of the machine."""


class Team:
    """A crew in one loop with a course."""

    def __init__(self, scenario: Scenario) -> None:
        self.crew = crew.assemble(agent_config(scenario), np.arange(scenario.robots.number))
        self.minds, self.said = crew.start(self.crew), silence()

    def step(self, course: Course) -> None:
        """Go through one tick."""
        anew = course.state.since == course.state.tick
        if anew.any() and course.state.tick > 0:
            self.minds = crew.forget(self.crew, self.minds, anew)
        sent = course.observations(course.state.present)
        self.minds, self.said, twists = crew.step(self.crew, self.minds, simulation.observe(course.state), self.said)
        told = crew.telemetry(self.crew, self.minds)
        spoken = [payload for _, *payload in assembly.payloads(self.said, twists, told)]

        def heard(tick: int, legible: Bools) -> list[bytes]:
            return [beacon if good else b"" for (beacon, _), good in zip(spoken, legible.tolist(), strict=True)]

        course.take(sent, [(messages.decode_command(command), command) for _, command in spoken], heard, 0.1)
        course.account(np.ones(len(sent), dtype=np.uint8))


@pytest.mark.parametrize("name", ["paper.toml", "measured.toml"])
@pytest.mark.parametrize("recorded", [True, False], ids=["recorded", "not recorded"])
def test_a_run_can_be_gone_on_with_after_every_tick(tmp_path: Path, name: str, recorded: bool) -> None:
    bursts = {"bad_share": 0.2, "mean_length": 0.1}
    faults = [
        {"at": 0.3, "transmitter": {"robot": 2, "loss": 0.5}},
        {"at": 0.5, "transmitter": {"robot": 3, "corrupt": True}},
    ]
    scenario = load(name, run__duration=0.8, channel__bursts=bursts, event=faults)
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    team = Team(scenario)
    with Recorder(first / NAME, scenario, name, "processes") as recorder:
        course = Course(scenario, recorder if recorded else None)
        keeper = Keeper(first, 1e9, name, "main")
        keeper.begin(course)
        for tick in range(scenario.ticks):
            if tick == 13:
                course.change("channel.reference_snr", 2e6)
            if tick == 20:  # a robot goes and comes back within a tick
                everybody = course.state.present
                course.attend(everybody & (course.world.ids != 2))
                course.attend(everybody)
            if tick % 7 == 5:
                keeper.save(course, {}, 0.1, at_once=True)
            team.step(course)
            shutil.rmtree(second, ignore_errors=True)
            shutil.copytree(first, second)
            snapshot = resume.load(second)
            assert snapshot.state.tick == max(0, (tick + 2) // 7 * 7 - 2 if tick >= 5 else 0)
            again = resume.recorder(second, snapshot)
            assert (again is not None) == recorded
            other, kept, _ = resume.course(second, snapshot, again, 1e9)
            assert other.state.tick == tick + 1
            assert other.state.poses.tobytes() == course.state.poses.tobytes()
            assert other.state.radio.burst.tobytes() == course.state.radio.burst.tobytes()
            assert other.state.channel == course.state.channel
            assert other.scenario == course.scenario
            assert other.sums.tally.digest.text() == course.sums.tally.digest.text()
            assert other.sums.tracking.table() == course.sums.tracking.table()
            if again is not None:
                with suppress(FesError), again:
                    raise FesError("it was stopped")
                whole = log.load(second / NAME)
                assert sum(1 for _ in whole.ticks()) == tick + 1
                again_of_it = replay.again(whole, everybody=True)
                assert again_of_it["digest"] == course.sums.tally.digest.text()
            kept.discard(other)
            assert not (second / FOLDER).exists()
        keeper.discard(course)


def test_the_last_note_may_be_torn(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    kept = journal.Journal(path)
    notes: list[list[Any]] = [["attend", 3, [0, 1]], ["tick", 3, [b"\x00\xff", b""], []]]
    ends = []
    for note in notes:
        kept.add(note)
        ends.append(path.stat().st_size)
    kept.close()
    whole = path.read_bytes()
    for length in range(len(whole) + 1):
        path.write_bytes(whole[:length])
        assert list(journal.notes(path)) == notes[: sum(end <= length for end in ends)]
    path.write_bytes(whole[:-1] + b"x")
    assert list(journal.notes(path)) == notes[:1]


def test_who_shares_a_process_is_what_was_last_joined(tmp_path: Path) -> None:
    course, keeper = Course(load("neighborhood.toml")), Keeper(tmp_path, 1e9, "test", "main")
    keeper.begin(course)
    for robots in ([0, 1, 2], [0], [1, 2], [0, 1, 2], [2]):
        keeper.note(["join", robots])
    keeper.close(course)
    again, kept, _ = resume.course(tmp_path, resume.load(tmp_path), None, 1e9)
    assert kept.groups == {0: (0, 1, 2), 1: (0, 1, 2), 2: (2,)}
    assert kept.renewed == {0, 1, 2}
    kept.note(["tick", 0, [b"", b"x", b"x"], [], 0.0])
    assert kept.renewed == {0}
    kept.discard(again)


def test_a_damaged_log_is_one_line(tmp_path: Path) -> None:
    scenario = load("pair.toml", run__duration=0.2)
    team, keeper = Team(scenario), Keeper(tmp_path, 1e9, "pair", "main")
    with suppress(FesError), Recorder(tmp_path / NAME, scenario, "pair", "processes") as recorder:
        course = Course(scenario, recorder)
        keeper.begin(course)
        for _ in range(5):
            team.step(course)
        keeper.save(course, {}, 0.1, at_once=True)
        keeper.close(course)
        raise FesError("it was stopped")
    whole, snapshot = (tmp_path / NAME).read_bytes(), resume.load(tmp_path)
    assert snapshot.log is not None
    for damaged in (b"", whole[: snapshot.log.size // 2], whole[: snapshot.log.size - 1], b"x" + whole[1:]):
        (tmp_path / FOLDER / f"log-{snapshot.number}").unlink(missing_ok=True)
        (tmp_path / NAME).write_bytes(damaged)
        with pytest.raises(FesError, match=r"^the log of .* cannot be gone on with: it is damaged "):
            resume.recorder(tmp_path, snapshot)


def begun(where: Path) -> Path:
    """A run directory with a checkpoint."""
    where.mkdir()
    course = Course(load("pair.toml"))
    keeper = Keeper(where, 1e9, "pair", "main")
    keeper.begin(course)
    keeper.close(course)
    return where / FOLDER / "state"


class Trap:
    """Runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return os.mkdir, ("trapped",)


def test_a_checkpoint_cannot_run_anything(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    state = begun(tmp_path / "run")
    magic, version, _ = state.read_bytes().split(b"\n", 2)
    state.write_bytes(b"\n".join([magic, version, pickle.dumps(Trap())]))
    with pytest.raises(FesError, match=r"is damaged: UnpicklingError$"):
        resume.load(tmp_path / "run")
    assert not Path("trapped").exists()


def test_what_cannot_be_gone_on_from_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(FesError, match=r"has no checkpoint: its run is over, or kept none$"):
        resume.load(tmp_path)
    state = begun(tmp_path / "run")
    whole = state.read_bytes()
    magic, _, told = whole.split(b"\n", 2)
    for damaged, complaint in [
        (b"", "is not a checkpoint$"),
        (b"fes checkpoint 9\n1\n", "is not a checkpoint that this fes can read$"),
        (magic + b"\n9.9\n" + told, "was kept by fes 9.9, this is "),
        (whole[:-10], "is damaged: "),
        (magic + b"\n" + whole.split(b"\n")[1] + b"\n" + pickle.dumps(3), "is not a checkpoint$"),
    ]:
        state.write_bytes(damaged)
        with pytest.raises(FesError, match=complaint):
            resume.load(tmp_path / "run")
    state.write_bytes(whole)
    snapshot = resume.load(tmp_path / "run")
    notes = journal.Journal(checkpoint.journals(tmp_path / "run", 0)[-1])
    notes.add(["tick", 7, [], []])
    notes.close()
    with pytest.raises(FesError, match=r"are damaged: a note of tick 7 stands at tick 0$"):
        resume.course(tmp_path / "run", snapshot, None, 1e9)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "give a SCENARIO, or --resume RUN_DIR"),
        (["--resume", "nowhere"], "nowhere has no checkpoint"),
        (["x.toml", "--resume", "nowhere"], "--resume goes on with the run as it was"),
        (["--resume", "nowhere", "--seed", "3"], "--resume goes on with the run as it was"),
    ],
)
def test_flags_that_do_not_go_together_are_one_line(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["fes-world", *words])
    with pytest.raises(SystemExit):
        main()
    assert complaint in capsys.readouterr().err
