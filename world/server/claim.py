"""One world a run: a claim that a world makes before it does anything else.

A world first declares a token of its own, then looks who else has one. If two start at the same time, at least one
of them sees the other's: of two tokens that pass one router, the later one's owner looks later still. It may be that
both see each other, and neither starts: a person starts one again, where two worlds would have moved one team.
"""

import asyncio
import uuid

from fes.errors import Rejected
from fes.protocol import keys
from fes.transport.bus import Bus

TIMEOUT = 10.0
"""How long a look may take [s]: who cannot look does not start."""

SETTLING = 0.3
"""A world that is connected to others waits this long [s] for its claim and theirs to cross the network."""


async def claim_run(bus: Bus, run: str, *, connected: bool) -> None:
    """Claim the run, until the session ends; raises Refused if another world has it or claims it too,
    and Absent if that cannot be seen.
    """
    own = keys.claim(run, uuid.uuid4().hex)
    bus.declare_token(own)
    if connected:
        await asyncio.sleep(SETTLING)
    others = set(await bus.liveliness_get(keys.world_tokens(run), TIMEOUT)) - {own}
    if others:
        raise Rejected(
            f"another world of run '{run}' is here, or starts just now (--run gives this one another name)"
        )
