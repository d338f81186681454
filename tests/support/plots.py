"""Tests that draw: skipped, and loudly so, where a library or a program for it is not installed."""

import importlib.util
import shutil

import pytest

from fes.system import distribution

needs_pillow = pytest.mark.skipif(
    importlib.util.find_spec("PIL") is None or importlib.util.find_spec("matplotlib") is None,
    reason=f"Pillow and matplotlib are not installed; these tests run after {distribution.install('plot')}",
)

needs_ffmpeg = pytest.mark.skipif(
    shutil.which("ffmpeg") is None or shutil.which("ffprobe") is None,
    reason="ffmpeg and ffprobe are not on the PATH; these tests run after apt-get install ffmpeg",
)
