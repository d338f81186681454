"""fes fit, from a file to TOML that a scenario accepts, to JSON and to a picture."""

import json
import shlex
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.fit import command, estimate, measurements, picture, report, shares
from console.fit.command import Model
from fes.errors import FesError
from tests.support import measured_links
from tests.support.loop import load
from world.config import scenario


def fit(path: Path, **options: Any) -> int:
    return command.fit(path, **{"model": Model.RAYLEIGH, "spectral_efficiency": 2.0, **options})


@pytest.fixture
def packets(tmp_path: Path) -> Path:
    return measured_links.write(tmp_path / "packets.csv", measured_links.packets(measured_links.rayleigh, 3))


@pytest.fixture
def powers(tmp_path: Path) -> Path:
    return measured_links.write(tmp_path / "powers.csv", measured_links.powers(3, -80.0, True))


@pytest.mark.parametrize("model", Model)
def test_the_lines_are_toml_that_a_scenario_accepts(
    packets: Path, model: Model, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fit(packets, model=model) == 0
    text = capsys.readouterr().out
    path = tmp_path / "scenario.toml"
    head = 'schema = 1\n[robots]\ncount = 2\n[seeking]\nindex = "measured"\n'
    path.write_text(head + text, encoding="utf-8")
    channel = scenario.load(path).channel
    assert channel.model == model.value
    assert tomllib.loads(text)["channel"] == json.loads(
        channel.model_dump_json(include=set(tomllib.loads(text)["channel"]))
    )


@pytest.mark.parametrize("model", Model)
def test_the_flags_of_fes_run_set_the_same_channel(
    packets: Path, model: Model, capsys: pytest.CaptureFixture[str]
) -> None:
    fit(packets, model=model)
    text = capsys.readouterr().out
    [flags] = [line.partition(": ")[2] for line in text.splitlines() if line.startswith("# as flags of fes run: ")]
    words = [word for word in shlex.split(flags) if word != "--set"]
    overrides = dict(scenario.parse_override(word) for word in words)
    channel = load("measured.toml", **{path.replace(".", "__"): value for path, value in overrides.items()}).channel
    expected = tomllib.loads(text)["channel"]
    assert json.loads(channel.model_dump_json(include=set(expected))) == expected


def test_the_comments_have_counts_method_intervals_and_the_optimum(
    packets: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fit(packets)
    lines = capsys.readouterr().out.splitlines()
    measured = measured_links.packets(measured_links.rayleigh, 3)
    least, most = measured.separation.min(), measured.separation.max()
    assert lines[:3] == [
        f"# packets.csv: 500 packets over {least:g} to {most:g} m, {measured.decoded.sum()} of them decoded",
        "# maximum likelihood; 95 % intervals from the observed Fisher information",
        "[channel]",
    ]
    expected = estimate.fit(measured, "rayleigh", 2.0)
    low, high = expected.intervals["path_loss_exponent"]
    assert any(
        line.startswith("path_loss_exponent = ") and line.endswith(f"# 1; 95 %: {low:.4g} to {high:.4g}")
        for line in lines
    )
    assert expected.optimal_interval is not None
    low, high = expected.optimal_interval
    optimum = f"# r* = {expected.optimal:.2f} m for the default objective, 95 %: {low:.4g} to {high:.4g} m"
    assert lines[-2] == optimum


def test_received_power_has_its_threshold_and_what_it_implies_in_the_comments(
    powers: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fit(powers, sensitivity=-80.0)
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "# least power that decodes: -80 dBm; 0 are below, so it has decoded packets only"
    assert lines[3].startswith("# deviation of the power / mean = ")
    # 10 log10(2^2 - 1) = 4.771 dB above the noise
    fit(powers, noise_floor=-80.0 - 4.771212547196624)
    by_noise = capsys.readouterr().out.splitlines()
    assert by_noise == lines
    fit(powers, noise_floor=-70.0)
    assert "are below, so it has lost packets too" in capsys.readouterr().out.splitlines()[1]


def test_the_threshold_is_the_sensitivity_or_follows_from_the_noise() -> None:
    assert measurements.threshold(None, None, 2.0) is None
    assert measurements.threshold(None, -91.0, 2.0) == -91.0
    assert measurements.threshold(-95.0, None, 1.0) == -95.0  # 2^1 - 1 = 1: 0 dB
    with pytest.raises(FesError, match="not both"):
        measurements.threshold(-95.0, -91.0, 2.0)


def test_json_holds_the_fit_and_nothing_else(packets: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit(packets, json_=True)
    table = json.loads(capsys.readouterr().out)
    measured = measured_links.packets(measured_links.rayleigh, 3)
    expected = estimate.fit(measured, "rayleigh", 2.0)
    assert table == json.loads(json.dumps(report.table(expected, measured)))
    assert table["channel"] == expected.settings
    assert (table["rows"], table["decoded"]) == (500, int(measured.decoded.sum()))


REFUSALS = [
    ("separation,decoded\n", {}, " has no row after its line of names"),
    ("separation,decoded\n10,1\n20,1\n", {}, ": all 2 packets decoded: a fit needs decoded and lost ones"),
    ("separation,decoded\n10,0\n20,0\n", {}, ": all 2 packets were lost: a fit needs decoded and lost ones"),
    ("separation,decoded\n10,0\n10,1\n", {}, ": all rows have one separation, 10 m: a fit needs at least two"),
    ("separation,decoded\nnear,1\n20,0\n", {}, ", line 2: separation must be a number from 0.001 to 1e+06, got "),
    ("separation,decoded\n10,1\n0,0\n", {}, ", line 3: separation must be a number from 0.001 to 1e+06, got 0"),
    ("separation,decoded\n10,1\n20,maybe\n", {}, ", line 3: decoded must be 0 or 1, got 'maybe'"),
    ("separation,decoded\n10,1\n20,0\n", {"sensitivity": -80.0}, " has no column rssi, so --noise-floor and"),
    ("distance,decoded\n10,1\n", {}, ", line 1: must name the columns separation, decoded or rssi, got 'distance,"),
    ("separation,rssi\n10,-50\n20,-60\n", {}, " has received power: give --noise-floor or --sensitivity, "),
    ("separation,rssi\n10,-50\n10,-60\n", {"sensitivity": -80.0}, ": all rows have one separation, 10 m"),
    ("separation,rssi\n10,-50\n20,loud\n", {"sensitivity": -80.0}, ", line 3: rssi must be a number from -300 to 1"),
    ("separation,rssi\n10,-60\n20,-50\n", {"sensitivity": -80.0}, ": path_loss_exponent must be from 0 to 20, "),
    ("separation,decoded\n10,1\n20,1\n30,0\n", {}, ": every packet up to 20 m decoded and every one from "),
    ("separation,decoded\n10,1\n20,0\n", {"model": Model.TABLE}, None),
]  # fmt: skip


@pytest.mark.parametrize(("text", "options", "rule"), REFUSALS)
def test_a_file_without_a_fit_is_refused_in_one_line(
    tmp_path: Path, text: str, options: dict[str, Any], rule: str | None
) -> None:
    path = tmp_path / "links.csv"
    path.write_text(text, encoding="utf-8")
    if rule is None:
        assert fit(path, **options) == 0
        return
    with pytest.raises(FesError) as caught:
        fit(path, **options)
    assert str(caught.value).startswith(f"{path}{rule}")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_missing_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(FesError, match=r"none\.csv cannot be read: No such file or directory$"):
        fit(tmp_path / "none.csv")


@pytest.mark.parametrize("model", Model)
def test_a_picture_has_the_shares_their_intervals_and_the_curve_with_its_band(model: Model) -> None:
    measured = measured_links.packets(measured_links.rayleigh, 3)
    fitted = estimate.fit(measured, model.value, 2.0)
    axes: Any
    [axes] = picture.figure_of(fitted, measured).axes
    [bars] = axes.containers
    marks = bars.lines[0].get_xydata()
    expected = shares.by_separation(measured)
    np.testing.assert_allclose(marks, np.column_stack([expected.separation, expected.share]))
    [segments] = [part.get_segments() for part in bars.lines[2]]
    np.testing.assert_allclose([part[:, 1] for part in segments], np.column_stack([expected.low, expected.high]))
    curve = axes.lines[0].get_xydata()
    np.testing.assert_allclose(curve[:, 1], fitted.band(curve[:, 0])[0])
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert set(labels) == {
        "95 % interval", f"fit: {model.value}", f"r* = {fitted.optimal:.2f} m", "measured, Wilson interval",
    }  # fmt: skip


def test_a_picture_of_received_power_has_the_mean_and_the_threshold() -> None:
    measured = measured_links.powers(3, -80.0, False)
    fitted = estimate.fit(measured, "rayleigh", 2.0)
    panels: list[Any] = picture.figure_of(fitted, measured).axes
    powers, curve = panels
    line = {line.get_label(): line.get_xydata() for line in powers.lines}
    assert len(line["measured"]) == 500
    assert (line["least that decodes"][:, 1] == -80.0).all()
    separation, mean = line["fit: mean power"].T
    # the truth is -20 dBm - 30 log10 r; 4 standard errors of the mean of 500 draws with 5.6 dB of fading
    assert abs(mean - (-20.0 - 30.0 * np.log10(separation))).max() < 4.0 * 5.6 / np.sqrt(500) * 2.0
    assert curve.get_ylabel() == "reception probability"


def test_a_picture_is_written_as_png_and_svg_and_named_in_a_comment(
    packets: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fit(packets, plot=tmp_path / "fit.svg")
    text = capsys.readouterr().out
    assert text.splitlines()[-2:] == [f"# picture: {tmp_path / name}" for name in ("fit.png", "fit.svg")]
    tomllib.loads(text)
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(FesError, match=r"^cannot write the picture: No such file or directory"):
        fit(packets, plot=tmp_path / "none" / "fit.svg")
