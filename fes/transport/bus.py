"""One session of Zenoh, everything that it declares, and the way from its threads to asyncio.

Zenoh calls handlers in threads of its own. A handler must only hand over (append, wake), never decode or compute. An
exception in it would be lost, and time spent in it holds up every other message.
docs/explanation/reliability.md lists the queues, ours and Zenoh's, and the effect of each when it is full.
"""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

import zenoh
import zenoh.handlers

from fes.errors import FesError, Overloaded, Rejected, Unavailable
from fes.transport import session
from fes.transport.endpoints import Endpoints

MAILBOX = 64
"""Largest number of samples in a mailbox: peers are at most one tick ahead, and 64 of the longest take 64 MiB."""

MAX_QUERIES = 64
"""Largest number of queries of one client that wait for one handler; further ones are rejected at once, undecoded."""

MAX_CLIENTS = 1024
"""Largest number of clients whose queries wait for one handler."""

REJECTION = b"refused: "
"""Prefix of a reply that rejects a query."""

OVERLOADED = "too many questions at once"
"""Reason of a rejection after which the same query may succeed later."""

LOCKSTEP = zenoh.Priority.INTERACTIVE_HIGH
"""Priority of all messages of the lockstep, because order holds only within one priority. Other messages
have Zenoh's default priority and another queue on each link: a flood of them delays no tick and closes no link."""

Handler = Callable[[str, bytes | None], None]
"""Called with the key and the payload of a sample (None for a deletion), in a thread of Zenoh."""

Gate = Callable[[str, bytes], bool]
"""True if a sample may pass; called with its key and its sender's mark (empty if none), in a thread of Zenoh."""


@dataclass(frozen=True)
class Query:
    """A query that waits for its reply."""

    key: str
    payload: bytes
    _query: Any

    def reply(self, payload: bytes, schema: str) -> None:
        """Reply to the query."""
        with self._query as query:
            query.reply(self.key, payload, encoding=_encoding(schema))

    def reply_err(self, reason: str) -> None:
        """Reject the query, with a reason in one line."""
        with self._query as query:
            query.reply_err(REJECTION + reason.encode())


def _payload(sample: zenoh.Sample) -> bytes | None:
    """The payload of a sample; None for a deletion, which has none."""
    payload = sample.payload.to_bytes()
    return payload if payload or sample.kind == zenoh.SampleKind.PUT else None


class Mailbox:
    """Samples that wait to be taken, the oldest first; when it is full the oldest is dropped."""

    def __init__(self, subscriber: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]") -> None:
        self._subscriber = subscriber

    def close(self) -> None:
        """End the subscription."""
        self._subscriber.undeclare()

    def take(self) -> tuple[str, bytes | None] | None:
        """The key and payload of the next sample (payload None for a deletion), or None if there is none."""
        sample = self._subscriber.try_recv()
        if sample is None:
            return None
        return str(sample.key_expr), _payload(sample)

    def payloads(self) -> list[bytes | None]:
        """The payloads of the samples that wait, without their keys: MAILBOX at most, as more may arrive."""
        payloads: list[bytes | None] = []
        receive = self._subscriber.try_recv
        while len(payloads) < MAILBOX and (sample := receive()) is not None:
            payloads.append(_payload(sample))
        return payloads


class Bus:
    """An open session."""

    def __init__(self, session: zenoh.Session, loop: asyncio.AbstractEventLoop) -> None:
        self._session = session
        self._loop = loop
        self._held: list[Any] = []

    @property
    def session(self) -> zenoh.Session:
        """The Zenoh session, for `fes.transport.foreign`."""
        return self._session

    def hold(self, declared: object) -> None:
        """Keep a declaration until the session closes."""
        self._held.append(declared)

    def declare_publisher(
        self, key: str, schema: str, *, drop: bool = False, mark: bytes | None = None
    ) -> Callable[[bytes], None]:
        """A function that puts a payload on `key`, with the `mark` of its sender beside it if there is one.

        The function waits while the network is congested, since one lost message would stop the lockstep. With `drop`
        it drops the message instead, since an observer must never hold up a tick.
        """
        control = zenoh.CongestionControl.DROP if drop else zenoh.CongestionControl.BLOCK
        priority = zenoh.Priority.DATA if drop else LOCKSTEP
        declared = self._session.declare_publisher(
            key, encoding=_encoding(schema), congestion_control=control, priority=priority, express=False
        )
        self._held.append(declared)
        return declared.put if mark is None else partial(declared.put, attachment=mark)

    def declare_subscriber(self, key: str, handler: Handler, gate: Gate | None = None) -> Callable[[], None]:
        """Hand every sample on `key` that may pass the `gate` to `handler`; returns a function that unsubscribes."""

        def on_sample(sample: zenoh.Sample) -> None:
            name = str(sample.key_expr)
            if gate is not None:
                mark = sample.attachment
                if not gate(name, b"" if mark is None else mark.to_bytes()):
                    return
            handler(name, _payload(sample))

        declared = self._session.declare_subscriber(key, zenoh.handlers.Callback(on_sample, indirect=False))
        return declared.undeclare

    def mailbox(self, key: str) -> "Mailbox":
        """A mailbox for samples on `key`, which arrive without waking Python."""
        channel: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(MAILBOX)
        return Mailbox(self._session.declare_subscriber(key, channel))

    def declare_token(self, key: str) -> None:
        """Declare a liveliness token. It lasts until the session closes or the process dies."""
        self._held.append(self._session.liveliness().declare_token(key))

    def declare_liveliness_subscriber(self, key: str, handler: Callable[[str, bool], None]) -> Callable[[], None]:
        """Call `handler(key, alive)` on the loop with each token, also present ones; returns a function to end it."""

        def on_change(sample: zenoh.Sample) -> None:
            alive = sample.kind == zenoh.SampleKind.PUT
            self._loop.call_soon_threadsafe(handler, str(sample.key_expr), alive)

        callback = zenoh.handlers.Callback(on_change, indirect=False)
        self._held.append(declared := self._session.liveliness().declare_subscriber(key, callback, history=True))
        return declared.undeclare

    async def liveliness_get(self, key: str, timeout: float) -> list[str]:
        """The present liveliness tokens on `key`; raises Unavailable without the router's answer in `timeout` [s]."""
        tokens: set[str] = set()  # one of this session arrives twice: from itself and from the router
        failed: list[zenoh.Reply] = []
        done = asyncio.Event()
        callback: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda reply: tokens.add(str(reply.ok.key_expr)) if reply.ok is not None else failed.append(reply),
            drop=lambda: self._loop.call_soon_threadsafe(done.set),
            indirect=False,
        )
        self._session.liveliness().get(key, callback, timeout=timeout)
        await done.wait()
        if failed:
            raise Unavailable(f"the router does not say within {timeout:g} s who is alive on {key}")
        return sorted(tokens)

    def declare_queryable(
        self, key: str, handler: Callable[[Query], None], is_free: Callable[[], bool] = lambda: True
    ) -> None:
        """Call `handler` on the loop with each query on `key`; while not `is_free()`, queries are rejected.

        At most MAX_QUERIES of one client wait. The last part of a key names the client, so that a flood of one robot
        does not crowd out the others. A FesError that the handler raises rejects the query.
        """
        waiting: dict[str, deque[Query]] = {}

        def answer(client: str, queue: deque[Query]) -> None:
            query = queue.popleft()
            if not queue:
                waiting.pop(client, None)
            try:
                handler(query)
            except FesError as error:
                query.reply_err(str(error))

        def on_query(query: zenoh.Query) -> None:
            name = str(query.key_expr)
            client = name.rpartition("/")[2]
            queue = waiting.get(client)
            has_room = len(waiting) < MAX_CLIENTS if queue is None else len(queue) < MAX_QUERIES
            if not has_room or not is_free():
                Query(name, b"", query).reply_err(OVERLOADED)
                return
            if queue is None:
                queue = waiting.setdefault(client, deque())
            payload = query.payload.to_bytes() if query.payload is not None else b""
            queue.append(Query(name, payload, query))
            self._loop.call_soon_threadsafe(answer, client, queue)

        self._held.append(self._session.declare_queryable(key, zenoh.handlers.Callback(on_query, indirect=False)))

    async def get(self, key: str, payload: bytes, timeout: float) -> bytes:
        """The reply to a query on `key`; raises Rejected, Overloaded, or Unavailable after `timeout` [s]."""
        future: asyncio.Future[zenoh.Reply | None] = self._loop.create_future()

        def settle(reply: zenoh.Reply | None) -> None:
            if not future.done():
                future.set_result(reply)

        callback: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda reply: self._loop.call_soon_threadsafe(settle, reply),
            drop=lambda: self._loop.call_soon_threadsafe(settle, None),
            indirect=False,
        )
        self._session.get(key, callback, payload=payload, timeout=timeout)
        reply = await future
        if reply is None:
            raise Unavailable(f"no process answers on {key}")
        if reply.ok is not None:
            return reply.ok.payload.to_bytes()
        answer = reply.err.payload.to_bytes() if reply.err is not None else b""
        if answer.startswith(REJECTION):
            why = answer.removeprefix(REJECTION).decode(errors="replace")
            raise Overloaded(why) if why == OVERLOADED else Rejected(why)
        raise Unavailable(f"no process answered on {key} within {timeout:g} s")  # Zenoh's error reply at a timeout


@asynccontextmanager
async def opened(endpoints: Endpoints) -> AsyncIterator[Bus]:
    """An open bus, closed at the end of the block.

    Raises TransportError in one line: port taken, no process listening, bad flag.
    """
    with await session.begin(endpoints) as begun:
        yield Bus(begun, asyncio.get_running_loop())


def log(levels: str) -> None:
    """Let Zenoh log to standard output, in this process from now on; RUST_LOG takes precedence over `levels`."""
    zenoh.init_log_from_env_or(levels)


def _encoding(schema: str) -> zenoh.Encoding:
    return zenoh.Encoding("application/x-msgpack").with_schema(schema)
