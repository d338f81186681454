"""Keys of programs that are not ours, such as ROS 2 nodes: raw payloads, each with an attachment.

A stale command is worse than none. So a publisher here never waits: the message is dropped, and sent at once or not
at all.
"""

from collections.abc import Callable

import zenoh
import zenoh.handlers

from fes.transport.bus import Bus

Put = Callable[[bytes, bytes], None]
"""Puts a payload and its attachment; an empty attachment stands for none."""

RawHandler = Callable[[str, bytes, bytes], None]
"""Called with the key, the payload and the attachment (empty if none) of a sample, in a thread of Zenoh."""


def declare_publisher(bus: Bus, key: str) -> Put:
    """A function that puts payloads on `key` at the highest priority; a congested network drops them."""
    declared = bus.session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=zenoh.Priority.REAL_TIME,
        express=True,
        reliability=zenoh.Reliability.BEST_EFFORT,
    )
    bus.hold(declared)

    def put(payload: bytes, attachment: bytes) -> None:
        if attachment:
            declared.put(payload, attachment=attachment)
        else:
            declared.put(payload)

    return put


def declare_subscriber(bus: Bus, key: str, handler: RawHandler, *, remote_only: bool = False) -> None:
    """Hand every sample on `key` to `handler`; with `remote_only` none that this session itself has put."""

    def on_sample(sample: zenoh.Sample) -> None:
        mark = sample.attachment
        handler(str(sample.key_expr), sample.payload.to_bytes(), b"" if mark is None else mark.to_bytes())

    origin = zenoh.Locality.REMOTE if remote_only else zenoh.Locality.ANY
    callback = zenoh.handlers.Callback(on_sample, indirect=False)
    bus.hold(bus.session.declare_subscriber(key, callback, allowed_origin=origin))


def session_id(bus: Bus) -> str:
    """The id of a session, in hexadecimal, as the liveliness tokens of other programs have it."""
    return str(bus.session.zid())
