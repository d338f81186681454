"""A run as an animation: frames drawn with matplotlib, as a GIF by Pillow or as an MP4 by ffmpeg.

Matplotlib, which brings Pillow, comes with the extra `plot`; ffmpeg is a program of its own.
"""

import logging
import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from console.analysis import figures, frames
from console.analysis.frames import HOLD, Playback
from console.analysis.history import History
from console.analysis.scene import COLORS, DPI, HEIGHT, WIDTH, Scene
from fes.arrays.types import Bytes
from fes.errors import FesError, reason

if TYPE_CHECKING:
    from PIL.Image import Image

GIF, MP4 = ".gif", ".mp4"

RATES = {GIF: 10.0, MP4: 20.0}
"""Suffix of a file -> frames per second."""

SHADES = 12
"""Shades of each color of a scene in a GIF."""

Watch = Callable[[int], None]
"""Called with the number of frames drawn so far."""


def check(path: Path) -> None:
    """Raise FesError if the suffix of `path` is unknown, or if a package or program for it is missing."""
    figures.require()
    if path.suffix.lower() not in RATES:
        raise FesError(f"an animation is a file that ends in {GIF} or {MP4}, got {path}")
    if path.suffix.lower() == MP4:
        from matplotlib.animation import FFMpegWriter

        if not FFMpegWriter.isAvailable():
            raise FesError(f"an {MP4} file needs ffmpeg, which is not on the PATH: install it, or write a {GIF} file")


def playback(run: History, path: Path) -> Playback:
    """The frames of the animation of a run in this file."""
    return frames.playback(len(run.time), run.scenario.run.dt, RATES[path.suffix.lower()])


def write(run: History, path: Path, watch: Watch | None = None) -> None:
    """Write the animation of a run as GIF or MP4, by the suffix; raises FesError, and then keeps an earlier file."""
    check(path)
    shown = playback(run, path)
    numbers = [frames.frame(run, tick) for tick in shown.ticks.tolist()]
    scene = Scene(run, numbers)

    def pictures() -> Iterator[Bytes]:
        for number, frame in enumerate(numbers, 1):
            yield scene.picture(frame)
            if watch is not None:
                watch(number)

    with _replaced(path) as part:
        (_write_gif if path.suffix.lower() == GIF else _write_mp4)(pictures(), shown.rate, part)


def still(run: History) -> "Image":
    """The last tick of a run as a picture with few colors."""
    last = frames.frame(run, len(run.time) - 1)
    return _few_colors(Scene(run, [last]).picture(last))


def _write_gif(pictures: Iterator[Bytes], rate: float, path: Path) -> None:
    images = [_few_colors(picture) for picture in pictures]
    period, hold = round(1000.0 / rate), round(1000.0 * HOLD)
    duration = [*[period] * (len(images) - 1), hold]
    images[0].save(path, save_all=True, append_images=images[1:], duration=duration, loop=0)


def _write_mp4(pictures: Iterator[Bytes], rate: float, path: Path) -> None:
    from matplotlib.animation import FFMpegWriter
    from matplotlib.figure import Figure

    canvas = Figure(figsize=(WIDTH / DPI, HEIGHT / DPI), dpi=DPI)
    shown = canvas.figimage(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    # The last frame stays, and a player can begin before it has the whole file.
    options = ["-vf", f"tpad=stop_mode=clone:stop_duration={HOLD:g}", "-movflags", "+faststart"]
    writer = FFMpegWriter(fps=rate, codec="h264", extra_args=options)  # type: ignore[arg-type]
    logging.getLogger("matplotlib.animation").setLevel(logging.ERROR)  # its warning would repeat that of ffmpeg
    with writer.saving(canvas, path, DPI):
        for picture in pictures:
            shown.set_data(picture)
            writer.grab_frame()


@cache
def _palette() -> "Image":
    """An image with the colors of a scene and their shades toward white, which are the same in every frame."""
    from matplotlib.colors import to_rgb
    from PIL import Image

    share = np.linspace(1.0, 0.0, SHADES, endpoint=False)[:, None]
    shades = [1.0 - share * (1.0 - np.array(to_rgb(color))) for color in COLORS]
    colors = np.rint(255.0 * np.concatenate([np.ones((1, 3)), *shades])).astype(int)
    palette = Image.new("P", (1, 1))
    palette.putpalette(colors.ravel().tolist())
    return palette


def _few_colors(picture: Bytes) -> "Image":
    from PIL import Image

    return Image.fromarray(picture).quantize(palette=_palette(), dither=Image.Dither.NONE)


@contextmanager
def _replaced(path: Path) -> Iterator[Path]:
    """A file to write within the block, which replaces `path` at its end; if it ends early, no part remains."""
    part = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        os.replace(part, path)
    except subprocess.CalledProcessError as error:
        lines = str(error.stderr or error).strip().splitlines()
        raise FesError(f"ffmpeg cannot write {path}: {lines[-1]}") from None
    except OSError as error:
        raise FesError(f"cannot write {path}: {reason(error, with_file=False)}") from None
    finally:
        with suppress(OSError):
            part.unlink()
