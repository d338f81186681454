"""The agent's end: start the gate as a child process, send it commands, and take poses and states from it."""

import asyncio
import contextlib
import subprocess
import sys
from collections import deque
from types import TracebackType

from fes.errors import MessageError, Unavailable
from field.gate import link
from field.gate.link import TO_AGENT, Command, FrameSocket, PoseSeen, Progress
from field.gate.rules.settings import Settings

MOST_POSES = 256
"""Most poses that wait to be taken; the oldest is dropped."""

END = 10.0
"""Longest wait for the end of a gate whose link is closed [s]."""


class AgentLink:
    """The link of an agent to its gate."""

    def __init__(self, frames: FrameSocket, child: "subprocess.Popen[bytes] | None" = None) -> None:
        self.pose: PoseSeen | None = None
        """The last pose."""
        self.progress: Progress | None = None
        """The last state of the gate."""
        self._frames = frames
        self._child = child
        self._poses: deque[PoseSeen] = deque(maxlen=MOST_POSES)
        self._news = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(frames.end, self._on_readable)

    @property
    def is_closed(self) -> bool:
        """True when the gate has ended."""
        return self._frames.is_closed

    @property
    def pid(self) -> int | None:
        """Id of the gate's process."""
        return None if self._child is None else self._child.pid

    def send(self, command: Command) -> bool:
        """Send a command, without waiting; False if it is dropped, because the gate is frozen or has ended."""
        return self._frames.send(link.encode_command(command))

    def sleep(self) -> None:
        """From now on wake the loop for no frame: only `take` reads them."""
        self._loop.remove_reader(self._frames.end)

    def take(self) -> list[PoseSeen]:
        """The poses that have arrived since the last call, the oldest first, MOST_POSES at most."""
        if not self.is_closed:
            self._on_readable()
        poses = list(self._poses)
        self._poses.clear()
        return poses

    async def changed(self) -> None:
        """Wait until a pose or a state has arrived since the last call, or the gate has ended."""
        if not self.is_closed:
            await self._news.wait()
        self._news.clear()

    async def close(self) -> int | None:
        """Close the link, which stops the body and ends the gate; returns its exit code, None for no process."""
        if self._frames.end.fileno() >= 0:
            self._loop.remove_reader(self._frames.end)
            self._frames.close()
        self._news.set()
        return None if self._child is None else await asyncio.to_thread(_end, self._child)

    async def __aenter__(self) -> "AgentLink":
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    def _on_readable(self) -> None:
        for frame in self._frames.receive():
            with contextlib.suppress(MessageError):
                message = link.decode_to_agent(frame)
                if isinstance(message, Progress):
                    self.progress = message
                else:
                    self.pose = message
                    self._poses.append(message)
        if self.is_closed:
            self._loop.remove_reader(self._frames.end)
        self._news.set()


async def launch(settings: Settings) -> AgentLink:
    """A link to a new gate that is ready, but stopped until an operator starts it.

    The gate has a session of its own, so that Ctrl-C in a terminal ends the agent first. Raises Unavailable if the
    gate ends before it is ready; its last line on standard error tells the reason.
    """
    own, far = link.pair()
    # -P: never take a folder `field` in the working directory for our package
    words = [sys.executable, "-P", "-m", "field.gate", "--link", str(far.fileno())]
    with far:
        child = subprocess.Popen(words, stdin=subprocess.PIPE, pass_fds=(far.fileno(),), start_new_session=True)
    if child.stdin is not None:
        with contextlib.suppress(BrokenPipeError), child.stdin:
            child.stdin.write(settings.to_json().encode() + b"\n")
    opened = AgentLink(FrameSocket(own, TO_AGENT), child)
    try:
        while opened.progress is None:
            if opened.is_closed:
                raise Unavailable(f"the gate of robot {settings.robot} ended before it was ready")
            await opened.changed()
    except BaseException:
        await opened.close()
        raise
    return opened


def _end(child: "subprocess.Popen[bytes]") -> int:
    """The exit code of a gate whose link is closed."""
    try:
        return child.wait(END)
    except subprocess.TimeoutExpired:  # it is frozen: only the driver's own timeout stops the body now
        child.kill()
        return child.wait()
