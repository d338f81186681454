"""The run that the network flags of a command name, and a session with it."""

import contextlib
import inspect
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from console.connect import options, run_directory
from console.connect.run_directory import Client
from console.terminal import progress
from fes import process
from fes.protocol import keys
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints


@dataclass(frozen=True)
class Reach:
    """A run, and the network flags by which a command reaches it."""

    role: str
    """Role of the certificate for a secured run."""
    run: str = keys.DEFAULT_RUN
    connect: list[str] | None = None
    config: Path | None = None
    cfg: list[str] | None = None
    certificates: Path | None = None

    def endpoints(self, timeout: float) -> Endpoints:
        """The endpoints of a client that connects within `timeout` [s]; raises FesError."""
        client = Client(self.role, self.certificates, self.run, timeout)
        return run_directory.endpoints(client, self.connect, self.config, self.cfg)

    def leave(
        self, timeout: float, main: Callable[[Bus], Coroutine[Any, Any, int]], *, needs_its_end: bool = False
    ) -> NoReturn:
        """Run `main` with a session, and end this process with its exit code, as `fes.process.leave` does."""
        endpoints = self.endpoints(timeout)

        async def connected() -> int:
            async with contextlib.AsyncExitStack() as stack:
                with progress.waiting("connecting"):
                    session = await stack.enter_async_context(bus.opened(endpoints))
                return await main(session)

        process.leave("fes", connected, needs_its_end=needs_its_end)


def reaching(role: str) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """A decorator for a command whose first parameter is a Reach: Typer gets the network flags in its place.

    Typer reads the flags from the signature.
    """
    flags: dict[str, Any] = {
        "connect": (options.Connect, None),
        "config": (options.Config, None),
        "cfg": (options.Cfg, None),
        "certificates": (options.KEYS[role], None),
        "run": (options.Run, keys.DEFAULT_RUN),
    }
    parameter = partial(inspect.Parameter, kind=inspect.Parameter.KEYWORD_ONLY)
    own = [parameter(name, annotation=hint, default=default) for name, (hint, default) in flags.items()]

    def decorate(command: Callable[..., int]) -> Callable[..., int]:
        def reached(**given: Any) -> int:
            return command(Reach(role, **{name: given.pop(name) for name in flags}), **given)

        _, *declared = inspect.signature(command, eval_str=True).parameters.values()
        declared = [given.replace(kind=inspect.Parameter.KEYWORD_ONLY) for given in declared]
        arguments = [given for given in declared if given.default is inspect.Parameter.empty]
        parameters = [*arguments, *own, *declared[len(arguments) :]]
        reached.__name__, reached.__doc__ = command.__name__, command.__doc__
        reached.__annotations__ = {each.name: each.annotation for each in parameters}
        reached.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        return reached

    return decorate
