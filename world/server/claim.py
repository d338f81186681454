"""One world per run: a claim that a world makes before it does anything else.

A world first declares a token of its own, then looks for tokens of other worlds. If two worlds start at the same
time, at least one of them sees the other's token. If both tokens pass one router, the world of the later token
looks after both have passed it. If both worlds see a token, neither starts, and a person starts one of them again.
Two running worlds would both move the same team.
"""

import asyncio
import uuid

from fes.errors import Rejected
from fes.protocol import keys
from fes.transport.bus import Bus

TIMEOUT = 10.0
"""A world that cannot look for other worlds within this time [s] does not start."""

SETTLING = 0.3
"""A world that is connected to others waits this long [s] for its claim and theirs to cross the network."""


async def claim_run(bus: Bus, run: str, *, connected: bool) -> None:
    """Claim the run until the session ends.

    Raises Rejected if another world has it or claims it too, and Unavailable if the other
    tokens cannot be queried within TIMEOUT.
    """
    own = keys.claim(run, uuid.uuid4().hex)
    bus.declare_token(own)
    if connected:
        await asyncio.sleep(SETTLING)
    others = set(await bus.liveliness_get(keys.world_tokens(run), TIMEOUT)) - {own}
    if others:
        raise Rejected(f"another world of run '{run}' is running or starting (--run gives this one another name)")
