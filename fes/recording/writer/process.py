"""The process that writes a log: it makes the file from the frames in its standard input, until that ends.

A run that is killed ends that input. Then this process writes all ticks that it has received, without an end of the
log, and exits. Stop signals do not reach it: a Ctrl-C goes to every process of a terminal, and the run ends in order.
"""

import contextlib
import os
import select
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fes.errors import FesError, reason
from fes.recording.writer import frames
from fes.recording.writer.log_file import LogFile
from fes.system import signals

PIECE = 1 << 20
"""Most that is read at once [bytes]."""

PERIOD = 0.5
"""Time between two looks at the age of a chunk, while no tick arrives [s]."""


def serve(log: LogFile, incoming: int, outgoing: int) -> None:
    """Write the frames that arrive at one file number, and send answers to another, to the end of the first."""
    with contextlib.closing(log):
        for request, method, *arguments in _frames(log, incoming):
            result = getattr(log, method)(*arguments)
            if request:
                _send(outgoing, frames.pack(request, result))
            if method == "finish":
                return
        log.position()


def _frames(log: LogFile, incoming: int) -> Iterator[list[Any]]:
    """The frames that arrive, to the end of their pipe; closes old chunks of the log in the meantime."""
    splitter = frames.Splitter()
    while True:
        if not select.select([incoming], [], [], PERIOD)[0]:
            log.settle()
            continue
        piece = os.read(incoming, PIECE)
        if not piece:
            return
        yield from splitter.feed(piece)


def main() -> None:
    """Run the writer; its arguments: the path of the log, the number of its file, and that of the pipe of answers."""
    signals.ignore()
    path, fileno, outgoing = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    try:
        serve(LogFile(path, fileno), sys.stdin.fileno(), outgoing)
        os._exit(0)  # saves the time that Python needs to end
    except FesError as error:
        why = str(error)
    except OSError as error:
        why = f"cannot write {path}: {reason(error, with_file=False)}"
    except BaseException as error:
        why = f"cannot write {path}: {type(error).__name__}: {' '.join(str(error).split())}"
    _send(outgoing, frames.pack(frames.FAILED, why))
    os._exit(1)


def _send(outgoing: int, frame: Any) -> None:
    """Write a frame; nothing if the run has ended."""
    try:
        while frame:
            frame = frame[os.write(outgoing, frame) :]
    except BrokenPipeError:
        return


if __name__ == "__main__":
    main()
