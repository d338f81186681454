"""A request to the world of a running run to change its channel, and its answer in words."""

import math

from fes.errors import Unavailable
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ChangeResult, ParameterChange
from fes.system import strict_json
from fes.transport.bus import Bus


async def send(bus: Bus, run: str, change: ParameterChange, timeout: float) -> ChangeResult:
    """The result of a change. Raises Rejected, and Unavailable without an answer in `timeout` [s].

    The router of a secured run drops the request of every role but the operator, so that no answer arrives.
    """
    try:
        answer = await bus.get(keys.change(run), channel_change.encode_change(change), timeout)
    except Unavailable:
        raise Unavailable(f"no world of run '{run}' answers") from None
    return channel_change.decode_result(answer)


def described(result: ChangeResult) -> str:
    """A result in words."""
    optimal = result.optimal_separation
    return f"{result.path} = {strict_json.dumps(result.value)} from tick {result.tick} on; " + (
        f"r* = {optimal:.3f} m" if math.isfinite(optimal) else "it has no r*"
    )
