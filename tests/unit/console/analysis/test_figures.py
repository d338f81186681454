"""Figures show what they claim, and the step study supports the default steps."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from console.analysis import command as analysis_command
from console.analysis import figures, history, step_study, team_figures
from console.analysis.history import History
from console.backends import inprocess
from fes.errors import FesError
from tests.support.loop import load
from world.metrics import summary


@pytest.fixture(scope="module")
def seen() -> History:
    return history.follow(load("paper.toml", run__duration=12.0))


def test_a_history_has_the_digest_of_the_run(seen: History) -> None:
    assert seen.digest == inprocess.run(load("paper.toml", run__duration=12.0), "paper")["digest"]


def test_both_sums_of_figure_six_are_below_tolerance_within_ten_seconds(seen: History) -> None:
    late = seen.time >= 10.0
    assert seen.disagreement[late].max() < 0.01
    assert seen.estimate_error[late].max() < 26 * 0.001  # 26 estimates; the dither's bias is 0.45 mm each


def test_figure_one_marks_the_points_of_the_paper() -> None:
    texts = [text.get_text() for text in figures.outage_figure().axes[0].texts]
    assert texts == ["A: 68 m, 9.0 %", "B: 105 m, 29.3 %", "C: 150 m, 63.7 %"]


def test_figure_three_marks_both_optima() -> None:
    texts = [text.get_text() for text in figures.index_figure().axes[0].texts]
    assert texts == ["68.11 m, J = 0.844", "105.38 m, J = 0.391"]


def test_trajectories_are_smooth(seen: History) -> None:
    """No heading of a moving robot jumps: positions turn by at most what a tick's arc can turn."""
    steps = np.diff(seen.poses[:, :, :2], axis=0)
    length = np.hypot(steps[..., 0], steps[..., 1])
    speed = length / 0.02
    assert speed.max() < 75.0  # m/s; (6) with errors of at most 75 m and mu = 1
    late = seen.time[:-2] > 1.0
    assert np.abs(np.diff(speed, axis=0))[late].max() < 5.0  # m/s per tick


def test_figures_are_written_as_png_and_svg_and_repeat_to_the_byte(tmp_path: Path, seen: History) -> None:
    first = figures.save(figures.formation_figure(seen), tmp_path / "one")
    again = figures.save(figures.formation_figure(seen), tmp_path / "two")
    assert [path.suffix for path in first] == [".png", ".svg"]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in again]
    assert first[0].read_bytes().startswith(b"\x89PNG")


def test_a_run_is_drawn_from_its_directory_and_only_if_its_digest_is_reproduced(tmp_path: Path) -> None:
    pair = load("pair.toml", run__duration=2.0)
    summary.write_scenario(tmp_path, pair)
    result = inprocess.run(pair, "pair")
    summary.write(tmp_path, result)
    analysis_command.plot(str(tmp_path))
    assert (tmp_path / "formation.svg").exists()
    assert (tmp_path / "convergence.png").exists()
    (tmp_path / "summary.json").write_text(json.dumps({**result, "digest": "0" * 64}))
    with pytest.raises(FesError, match="cannot be executed again bit for bit"):
        analysis_command.plot(str(tmp_path))
    (tmp_path / "summary.json").write_text(json.dumps({"clock": "robots"}))
    with pytest.raises(FesError, match=r"is a run of real robots, without figures: `fes replay .* --all` checks it$"):
        analysis_command.plot(str(tmp_path))
    (tmp_path / "empty").mkdir()
    with pytest.raises(FesError, match="is not a run directory"):
        analysis_command.plot(str(tmp_path / "empty"))
    with pytest.raises(FesError, match=r"no run .*nowhere; figures without one: paper, measured, team"):
        analysis_command.plot(str(tmp_path / "nowhere"))


@pytest.mark.slow
def test_the_default_sub_step_is_far_below_what_matters_and_converges_fast() -> None:
    for transform in ("none", "log"):
        errors = [step_study.seeking_error(step, transform) for step in (0.02, 0.01)]
        assert errors[0] < 1e-5
        assert errors[1] < errors[0] / 16.0  # better than fourth order


def test_a_run_shorter_than_a_dither_period_is_drawn_with_a_note_in_the_title(seen: History) -> None:
    short = history.follow(load("measured.toml", run__duration=1.0))
    assert short.averaged
    linked = [len(links) > 0 for links in short.links]
    assert any(linked)
    np.testing.assert_array_equal(np.isfinite(short.separation_error), linked)
    for tick in (linked.index(True), len(linked) - 1):
        ends = history.ends_at(short, tick)
        expected = np.abs(np.hypot(*(ends[:, 0] - ends[:, 1]).T) - short.optimal).max()
        assert short.separation_error[tick] == pytest.approx(expected, rel=1e-12)
    titles = [figures.convergence_figure(run).axes[2].get_title() for run in (short, seen)]
    assert [title.endswith("averaged over a dither period") for title in titles] == [True, False]


def test_the_errors_are_against_r_star_or_against_the_link_length_of_a_configuration(
    teams: dict[str, History],
) -> None:
    for name, symbol in (("links", "r^*"), ("shape", r"r_\beta")):
        titles = [panel.get_title() for panel in figures.convergence_figure(teams[name]).axes]
        assert [f"-{symbol}|" in title for title in titles] == [False, True, True]


def test_events_are_marked_and_named_unless_they_are_many() -> None:
    for number, named in ((1, 1), (figures.MOST_TEXTS + 1, 0)):
        times = [0.1 * (k + 1) for k in range(number)]
        changes = [{"at": time, "set": {"channel.reference_snr": 1e7 * (1.0 + time)}} for time in times]
        run = history.follow(load("pair.toml", run__duration=2.0, event=changes))
        for panel in figures.convergence_figure(run).axes:
            spans = [np.unique(np.asarray(line.get_xdata(), dtype=float)).tolist() for line in panel.lines]
            marks = [span for span in spans if len(span) == 1]
            np.testing.assert_allclose(marks, [[time] for time in times])
            assert len(panel.texts) == named
            assert all(text.get_text() == "channel: reference_snr" for text in panel.texts)


@pytest.mark.slow
def test_the_closed_loop_depends_on_the_tick_to_first_order() -> None:
    closed = load("neighborhood.toml")
    (_, coarse), (_, fine) = step_study.tick_errors(closed, (0.02, 0.005))
    assert 2.0 < coarse / fine < 8.0  # 4, were it exactly first order
    assert coarse < 5.0


@pytest.fixture(scope="module")
def teams() -> dict[str, History]:
    ends = {"links": "neighborhood.toml", "shape": "team-paper-start.toml"}
    short = {"run__duration": 4.0, "objective__team_index": True, "expect": []}
    return {title: history.follow(load(name, **short)) for title, name in ends.items()}


def test_a_history_has_the_team_index_of_the_run(teams: dict[str, History], seen: History) -> None:
    short = {"run__duration": 4.0, "objective__team_index": True}
    result = inprocess.run(load("neighborhood.toml", **short), "neighborhood")
    run = teams["links"]
    assert run.team.shape == (2, len(run.time))
    assert run.team[1, -1] == result["team_index_target"]
    assert run.team[0, -1] == pytest.approx(result["team_index"], abs=0.01)  # up to 0.1 s older
    assert len(run.cutting) == result["cutting_robots"]
    assert seen.team.size == 0


def test_a_run_with_a_team_index_has_a_figure_of_it(tmp_path: Path, teams: dict[str, History]) -> None:
    figure = team_figures.team_figure(teams["links"])
    lines = figure.axes[0].lines
    assert [line.get_label() for line in lines] == ["team index F", "target"]
    assert np.array_equal(lines[0].get_ydata(), teams["links"].team[0])
    number = len(teams["links"].cutting)
    assert figure.axes[1].get_title() == f"t = 3.98 s, {number} cutting robots"
    marks = [line for line in figure.axes[1].lines if line.get_marker() == "s"]
    assert np.size(marks[0].get_xdata()) == number > 1
    assert not [line for line in figure.axes[1].lines if line.get_marker() == "x" and np.size(line.get_xdata())]
    ticks = len(teams["links"].time)
    without = replace(teams["links"], present=np.tile(np.arange(10) != 6, (ticks, 1)))
    marks = [line for line in team_figures.team_figure(without).axes[1].lines if line.get_marker() == "x"]
    assert np.array_equal(marks[0].get_xydata(), without.poses[-1, 6:7, :2])
    two = load("pair.toml", run__duration=1.0, objective__team_index=True)
    summary.write_scenario(tmp_path, two)
    summary.write(tmp_path, inprocess.run(two, "pair"))
    analysis_command.plot(str(tmp_path))
    assert (tmp_path / "team.svg").exists()


def test_ends_are_drawn_side_by_side_on_one_scale(teams: dict[str, History]) -> None:
    figure = team_figures.ends_figure(teams)
    assert len(figure.axes) == 3
    assert len({(panel.get_xlim(), panel.get_ylim()) for panel in figure.axes}) == 1
    for panel, (name, run) in zip(figure.axes[1:], teams.items(), strict=True):
        assert panel.get_title().startswith(f"{name}\nF = {run.team[0, -1]:.3f}, ")
