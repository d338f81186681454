"""`fes plot RUN --animate` writes a GIF or an MP4 of sensible size, or says in one line why it cannot."""

import json
import os
import subprocess
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fes.system.distribution import install
from tests.support import recordings
from tests.support.commands import PROGRAMS, call, complaint
from tests.support.loop import load
from tests.support.plots import needs_ffmpeg, needs_pillow
from tests.support.processes import PATIENCE

LIMIT = 2_000_000
"""Largest size of an animation of 60 s of run [bytes]."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the log of ten robots over three seconds, in which one leaves: `run.mcap`."""
    folder = tmp_path_factory.mktemp("animation")
    scenario = load("neighborhood.toml", run__duration=3.0, event=[{"at": 1.5, "kill": [4]}], expect=[])
    recordings.record(folder / "run.mcap", scenario, "three seconds")
    return folder


def animate(folder: Path, file: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [str(PROGRAMS / "fes"), "plot", "run.mcap", "--animate", file],
        cwd=folder, env={**os.environ, **environment}, stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=4 * PATIENCE,
    )  # fmt: skip


@needs_pillow
def test_a_gif_has_a_frame_for_each_tenth_of_a_second_and_no_two_in_a_row_are_alike(folder: Path) -> None:
    from PIL import Image

    done = animate(folder, "new/run.gif")
    assert (done.returncode, done.stdout, done.stderr) == (0, "new/run.gif\n", "")
    assert (folder / "new" / "run.gif").stat().st_size < LIMIT / 2
    shown: Any
    with Image.open(folder / "new" / "run.gif") as shown:
        assert shown.n_frames == 40  # 3 s of run in 4 s
        assert shown.size[0] == 800
        pictures, times = [], []
        for number in range(shown.n_frames):
            shown.seek(number)
            pictures.append(np.asarray(shown.convert("RGB")))
            times.append(shown.info["duration"])
    assert times == [100] * 39 + [2000]
    assert all(np.any(before != after) for before, after in pairwise(pictures))
    # The axes below the panels do not flicker.
    assert all(np.array_equal(picture[340:, :], pictures[0][340:, :]) for picture in pictures)
    # The map is white at a corner, and the links of the last frame are blue, as their outage is low.
    assert pictures[-1][60, 80].tolist() == [255, 255, 255]
    assert np.any(np.all(pictures[-1][50:330, 70:430] == (0, 114, 178), axis=2))


@needs_pillow
@needs_ffmpeg
def test_an_mp4_has_twice_as_many_frames_and_holds_the_last_one(folder: Path) -> None:
    from PIL import Image

    done = animate(folder, "run.MP4")
    assert (done.returncode, done.stdout, done.stderr) == (0, "run.MP4\n", "")
    assert (folder / "run.MP4").stat().st_size < LIMIT / 2
    entries = "stream=width,height,nb_read_frames,r_frame_rate,codec_name,pix_fmt"
    words = ["ffprobe", "-v", "error", "-count_frames", "-show_entries", entries, "-of", "json", "run.MP4"]
    probed = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=True)
    (stream,) = json.loads(probed.stdout)["streams"]
    assert stream == {
        "codec_name": "h264", "pix_fmt": "yuv420p", "width": 800, "height": 420, "r_frame_rate": "20/1",
        "nb_read_frames": "120",  # 4 s, and 2 s of the last frame
    }  # fmt: skip
    subprocess.run(
        ["ffmpeg", "-v", "error", "-i", "run.MP4", "frame-%03d.png"],
        cwd=folder, stdin=subprocess.DEVNULL, timeout=PATIENCE, check=True,
    )  # fmt: skip
    pictures = []
    for path in sorted(folder.glob("frame-*.png")):
        with Image.open(path) as picture:
            pictures.append(np.asarray(picture.convert("L"), dtype=int))
    assert len(pictures) == 120
    moved = [np.abs(before - after).max() for before, after in pairwise(pictures[:80])]
    assert min(moved) > 100  # levels of gray, of the black mark of time; compression alone changes fewer
    assert np.abs(pictures[79] - pictures[-1]).max() < 100


@needs_pillow
def test_an_mp4_without_ffmpeg_is_refused_before_the_run_is_executed_again(folder: Path) -> None:
    line = complaint(animate(folder, "no.mp4", PATH=str(PROGRAMS)), "fes")
    assert line == "an .mp4 file needs ffmpeg, which is not on the PATH: install it, or write a .gif file"
    assert not (folder / "no.mp4").exists()


@needs_pillow
def test_a_broken_ffmpeg_leaves_one_line_and_no_file(folder: Path, tmp_path: Path) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\ncat > /dev/null\necho 'no encoder here' >&2\nexit 1\n", encoding="utf-8")
    program.chmod(0o755)
    line = complaint(animate(folder, "broken.mp4", PATH=f"{tmp_path}{os.pathsep}{os.environ['PATH']}"), "fes")
    assert line == "ffmpeg cannot write broken.mp4: no encoder here"
    assert not list(folder.glob("*broken.mp4"))


@needs_pillow
def test_an_animation_that_cannot_be_drawn_leaves_the_earlier_file(folder: Path, tmp_path: Path) -> None:
    program, earlier = tmp_path / "ffmpeg", folder / "earlier.mp4"
    program.write_text("#!/bin/sh\ncat > /dev/null\nexit 1\n", encoding="utf-8")
    program.chmod(0o755)
    earlier.write_text("an hour of work", encoding="utf-8")
    complaint(animate(folder, earlier.name, PATH=f"{tmp_path}{os.pathsep}{os.environ['PATH']}"), "fes")
    assert [path.read_text(encoding="utf-8") for path in folder.glob("*earlier.mp4")] == ["an hour of work"]


@needs_pillow
@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["run.mcap", "--animate", "run.webm"], "an animation is a file that ends in .gif or .mp4, got run.webm"),
        (["paper", "--animate", "a.gif"], "--animate draws a run directory or a log, got 'paper'"),
        (["run.mcap", "--animate", "a.gif", "--out", "b"], "--animate names its own file: omit --out b"),
        (["nowhere", "--animate", "a.gif"], "nowhere is not a run directory: it lacks scenario.toml or summary.json"),
        (["run.mcap", "--animate", "run.mcap/a.gif"], "cannot write run.mcap/a.gif: File exists"),
    ],
    ids=["suffix", "figures", "out", "no log", "folder"],
)
def test_a_target_that_cannot_be_animated_is_one_line(folder: Path, words: list[str], line: str) -> None:
    assert complaint(call(folder, "fes", "plot", *words), "fes").startswith(line)
    assert not (folder / "a.gif").exists()


def test_without_matplotlib_the_line_names_the_extra(folder: Path, tmp_path: Path) -> None:
    # A path hook that hides matplotlib, as in an installation without the extra.
    hidden = "import sys\nsys.modules['matplotlib'] = None\n"
    (tmp_path / "sitecustomize.py").write_text(hidden, encoding="utf-8")
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    line = complaint(animate(folder, "a.gif", PYTHONPATH=path), "fes")
    assert line == f"figures need matplotlib: {install('plot')}"
