"""fes team router: the network between operators and gates. With certificates each role has its own rights."""

import asyncio
import contextlib
import logging
from contextlib import AbstractAsyncContextManager
from pathlib import Path

from fes import process
from fes.transport import bus, identity
from fes.transport.endpoints import Endpoints, default_endpoint
from fes.transport.identity import WORLD
from world.server import access, audit

_logger = logging.getLogger("router")


async def serve(run: str, listen: tuple[str, ...], keys: Path | None, robots: int) -> int:
    """Carry the messages of a team until this task is cancelled; returns the exit code.

    With `keys`, a folder of certificates, the rights of `robots` robots, an observer and an operator are checked, and
    each message without a right is logged. Raises FesError for a certificate or an endpoint that cannot be used.
    """
    ends = listen or (default_endpoint(secure=keys is not None),)
    checks: AbstractAsyncContextManager[None] = contextlib.nullcontext()
    security = dict(identity.security(keys, WORLD))
    if keys is not None:
        rules = access.control(run, robots, identity.crews(keys))
        security |= rules
        checks = audit.running(access.roles(rules), _logger)
    async with checks, bus.opened(Endpoints("router", (), ends, security=security)):
        _logger.info("ready: the network of run '%s' at %s", run, ", ".join(ends))
        await asyncio.Event().wait()
    return process.SUCCESS
