"""The file of a trace: its rows, its place, its checksum, and one line for each broken file."""

import hashlib
from pathlib import Path
from typing import Any

import pytest

from fes.errors import FesError, ScenarioError
from world.config import scenario
from world.config.events import changed
from world.config.outside import trace_file
from world.config.scenario import Scenario

HEADER = "time,sender,receiver,probability\n"
TRACE = HEADER + "0,0,1,0.5\n1.5,1,0,1\n"


def checksum(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def written(folder: Path, trace: str = TRACE, more: str = "", model: str = "trace") -> Path:
    """A scenario that names a trace by a path from its own file."""
    (folder / "links.csv").write_text(trace, encoding="utf-8")
    path = folder / "scenario.toml"
    text = f"""schema = 1
[robots]
poses = [[0, 0, 0], [50, 0, 0]]
[seeking]
index = "measured"
[channel]
model = "{model}"
trace = "links.csv"
{more}"""
    path.write_text(text, encoding="utf-8")
    return path


def refusal(path: Path, overrides: dict[str, Any] | None = None) -> str:
    with pytest.raises(ScenarioError) as caught:
        scenario.load(path, overrides)
    return str(caught.value)


def test_a_row_is_a_time_a_sender_a_receiver_and_a_probability(tmp_path: Path) -> None:
    path = tmp_path / "links.csv"
    path.write_text(TRACE, encoding="utf-8")
    trace = trace_file.read(str(path), checksum(path))
    assert trace.time.tolist() == [0.0, 1.5]
    assert trace.sender.tolist() == [0, 1]
    assert trace.receiver.tolist() == [1, 0]
    assert trace.probability.tolist() == [0.5, 1.0]


def test_a_row_may_state_whether_a_beacon_decoded(tmp_path: Path) -> None:
    path = tmp_path / "links.csv"
    path.write_text("decoded,sender,receiver,time\n1,0,1,0\n0,1,0,-2\n", encoding="utf-8")
    trace = trace_file.read(str(path), checksum(path))
    assert trace.probability.tolist() == [1.0, 0.0]
    assert trace.time.tolist() == [0.0, -2.0]


@pytest.mark.parametrize(
    ("trace", "message"),
    [
        ("time,from,to,probability\n", ", line 1: must name the columns time, sender, receiver, probability or"),
        (HEADER, " has no row after its line of names"),
        (HEADER + "0,0,1,0.5\n0,0,1,1.5\n", ", line 3: probability must be a number from 0 to 1, got 1.5"),
        ("time,sender,receiver,decoded\n0,0,1,0.5\n", ", line 2: decoded must be 0 or 1, got 0.5"),
        (HEADER + "0,0.5,1,1\n", ", line 2: sender must be a whole number from 0 to 2.14748e+09, got 0.5"),
        (HEADER + "0,0,-1,1\n", ", line 2: receiver must be a whole number from 0 to 2.14748e+09, got -1"),
        (HEADER + "0,0,99999999999999999999,1\n", ", line 2: receiver must be a whole number from 0 to 2.14748e+09"),
        (HEADER + "noon,0,1,1\n", ", line 2: time must be a number from -1e+09 to 1e+09, got 'noon'"),
        (HEADER + "0,0,1\n", ", line 2: must have 4 fields, got 3: '0,0,1'"),
    ],
)  # fmt: skip
def test_a_scenario_with_a_broken_trace_is_refused_in_one_line(tmp_path: Path, trace: str, message: str) -> None:
    path = written(tmp_path, trace)
    assert refusal(path).startswith(f"{path}: channel.trace: {tmp_path / 'links.csv'}{message}")


def test_a_path_starts_from_the_scenarios_folder_and_that_of_a_set_from_the_current_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own").mkdir()
    (tmp_path / "current").mkdir()
    path = written(tmp_path / "own")
    (tmp_path / "current" / "links.csv").write_text(HEADER + "0,0,1,0.25\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path / "current")
    for overrides, folder in (({}, "own"), ({"channel.trace": "links.csv"}, "current")):
        channel = scenario.load(path, overrides).channel
        assert channel.trace == str(tmp_path / folder / "links.csv")
        assert channel.trace_sha256 == checksum(tmp_path / folder / "links.csv")


def test_another_trace_by_set_has_its_own_checksum(tmp_path: Path) -> None:
    path = written(tmp_path, more=f'trace_sha256 = "{hashlib.sha256(TRACE.encode()).hexdigest()}"')
    second = tmp_path / "second.csv"
    second.write_text(HEADER + "0,0,1,0.25\n", encoding="utf-8")
    assert scenario.load(path, {"channel.trace": str(second)}).channel.trace_sha256 == checksum(second)


def test_the_trace_of_a_scheme_starts_from_the_scenarios_folder_unless_a_set_gives_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own"
    own.mkdir()
    former = f'trace_sha256 = "{hashlib.sha256(TRACE.encode()).hexdigest()}"'
    written(own, more=f'{former}\n[[scheme]]\nname = "other"\nset = {{ "channel.trace" = "other.csv" }}')
    for probability, folder in enumerate((own, tmp_path)):
        (folder / "other.csv").write_text(f"{HEADER}0,0,1,{probability}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for overrides, folder in (({}, own), ({"channel.trace": "other.csv"}, tmp_path)):
        channel = scenario.load(Path("own/scenario.toml"), {"scheme": "other", **overrides}).channel
        assert channel.trace == str(folder / "other.csv")
        assert channel.trace_sha256 == checksum(folder / "other.csv")


def test_overrides_of_a_loaded_scenario_find_their_trace_in_the_current_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "current").mkdir()
    loaded = scenario.load(written(tmp_path))
    second = tmp_path / "current" / "second.csv"
    second.write_text(HEADER + "0,0,1,0.25\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path / "current")
    channel = scenario.with_overrides(loaded, {"channel.trace": "second.csv"}).channel
    assert (channel.trace, channel.trace_sha256) == (str(second), checksum(second))
    assert scenario.with_overrides(loaded, {"run.seed": 0}) == loaded
    with pytest.raises(ScenarioError, match=r"^scenario: channel\.trace: trace .*third\.csv cannot be read"):
        scenario.with_overrides(loaded, {"channel.trace": "third.csv"})


def test_a_trace_that_differs_from_its_checksum_is_refused_in_one_line(tmp_path: Path) -> None:
    path = written(tmp_path, more=f'trace_sha256 = "{"0" * 64}"')
    trace = tmp_path / "links.csv"
    assert refusal(path) == (
        f"{path}: channel.trace: {trace} has changed: its SHA-256 is {checksum(trace)[:12]}..., "
        "the scenario has 000000000000..."
    )


def test_a_change_is_noticed_although_the_file_was_read_before(tmp_path: Path) -> None:
    path = tmp_path / "links.csv"
    path.write_text(TRACE, encoding="utf-8")
    before = checksum(path)
    trace_file.read(str(path), before)
    path.write_text(TRACE + "2,0,1,1\n", encoding="utf-8")
    with pytest.raises(FesError, match="has changed"):
        trace_file.read(str(path), before)


def test_a_trace_that_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    path = written(tmp_path)
    (tmp_path / "links.csv").unlink()
    name = tmp_path / "links.csv"
    assert refusal(path) == f"{path}: channel.trace: trace {name} cannot be read: No such file or directory"
    name.mkdir()
    assert refusal(path) == f"{path}: channel.trace: {name}: is not a regular file"
    assert "null" in refusal(path, {"channel.trace": "a\0b"})


def test_an_event_names_a_trace_like_the_channel_does(tmp_path: Path) -> None:
    event = '[[event]]\nat = 1\nset = { "channel.trace" = "later.csv" }'
    later = tmp_path / "later.csv"
    later.write_text(HEADER + "0,0,1,0.25\n", encoding="utf-8")
    loaded = scenario.load(written(tmp_path, more=event))
    assert [channel.trace for channel in loaded.channels] == [str(tmp_path / "links.csv"), str(later)]
    assert [channel.trace_sha256 for channel in loaded.channels] == [
        hashlib.sha256(TRACE.encode()).hexdigest(),
        checksum(later),
    ]
    later.write_text(HEADER + "0,0,1,2\n", encoding="utf-8")
    assert "later.csv, line 2: probability must be a number from 0 to 1, got 2" in refusal(tmp_path / "scenario.toml")


EVENT = '[[event]]\nat = 1\nset = {{ "channel.model" = "{}" }}'


def test_a_channel_changes_to_and_from_a_trace_and_a_table(tmp_path: Path) -> None:
    rows = "rows = [[10, 1.0], [90, 0.5]]\n"
    for first, second in (("trace", "rayleigh"), ("rayleigh", "trace"), ("table", "trace"), ("trace", "table")):
        loaded: Scenario = scenario.load(written(tmp_path, more=rows + EVENT.format(second), model=first))
        assert [channel.model for channel in loaded.channels] == [first, second]


def test_a_change_that_lacks_its_data_is_refused_in_one_line(tmp_path: Path) -> None:
    path = written(tmp_path, more=EVENT.format("table"))
    assert refusal(path) == (f"{path}: event: set the channel: rows: model 'table' needs at least two, got 0")
    plain = scenario.load(path, {"event": []}).channel.model_copy(update={"trace": None, "model": "rayleigh"})
    with pytest.raises(ScenarioError, match=r"^the channel: model 'trace' needs the path of a file, `trace`$"):
        changed(plain, {"channel.model": "trace"}, 0.02)


def test_an_event_with_an_unknown_channel_is_refused_when_it_is_loaded(tmp_path: Path) -> None:
    path = written(tmp_path, more=EVENT.format("tabel"))
    assert refusal(path) == f"{path}: channel.model: there is no channel 'tabel'; did you mean 'table'?"


def test_an_oracle_is_not_told_a_channel_without_a_formula(tmp_path: Path) -> None:
    oracle = {"seeking.index": "oracle"}
    message = "a law is told the channel, and channel.model 'trace' has no formula"
    assert refusal(written(tmp_path), oracle).endswith(message)
    later = written(tmp_path, more=EVENT.format("trace"), model="rayleigh")
    assert refusal(later, oracle).endswith(message)


def test_shadowing_does_not_go_with_a_trace(tmp_path: Path) -> None:
    path = written(tmp_path, more="[channel.shadowing]\ndeviation = 4")
    assert refusal(path) == f"{path}: channel: shadowing acts on separations, which a trace does not have"


def test_separations_of_a_table_ascend(tmp_path: Path) -> None:
    path = written(tmp_path, more="rows = [[10, 1.0], [90, 0.5], [90, 0.25]]", model="table")
    assert refusal(path) == f"{path}: channel: rows: separations must ascend, got 90 and then 90"
