"""Sessions of Zenoh: their threads, their configuration, and the error when one does not open."""

import asyncio
import contextlib
import os
import threading
from dataclasses import replace
from pathlib import Path

# Set before the first session opens. One thread only sends. Else all threads may wait for room in full queues that
# none empties, and Zenoh closes links of healthy robots. Eight threads do the rest, because each may wait up to 10 s
# while Zenoh closes a session that ended silently. With two threads, two robots that hang would delay all robots.
os.environ.setdefault(
    "ZENOH_RUNTIME",
    "(rx:(handover:app),acc:(handover:app),tx:(worker_threads:1),net:(handover:app),app:(worker_threads:8))",
)

import zenoh

from fes import errors
from fes.errors import FesError, TransportError
from fes.system import encoding, strict_json
from fes.transport import addresses, connection_diagnosis
from fes.transport.endpoints import DEFAULT_ENDPOINT, Endpoints, warn_if_exposed

LONGEST_NAMESPACE = 1000
"""Longest namespace [characters]. Zenoh puts it before every key, and panics at a key of 65,535 bytes."""

LONGEST_SHOWN = 200
"""Longest part of a setting that a message shows [characters]."""


async def begin(endpoints: Endpoints) -> zenoh.Session:
    """An open session; raises TransportError in one line: port taken, no process listening, bad flag."""
    config = _config(endpoints)
    endpoints = _effective(endpoints, config)
    addresses.warn_of_names(endpoints.connect, endpoints.timeout)
    try:
        return await _open(config)
    except zenoh.ZError as error:
        raise TransportError(await asyncio.to_thread(connection_diagnosis.reason, endpoints, str(error))) from None


async def _open(config: zenoh.Config) -> zenoh.Session:
    """Open a session in a thread: Zenoh blocks while it tries to connect, and signals must be handled meanwhile."""
    loop = asyncio.get_running_loop()
    future: asyncio.Future[zenoh.Session] = loop.create_future()

    def settle(session: zenoh.Session | None, error: Exception | None) -> None:
        if future.cancelled():
            if session is not None:
                session.close()
        elif session is not None:
            future.set_result(session)
        elif error is not None:
            future.set_exception(error)

    def work() -> None:
        outcome: tuple[zenoh.Session | None, Exception | None]
        try:
            outcome = zenoh.open(config), None
        except Exception as error:
            outcome = None, error
        with contextlib.suppress(RuntimeError):  # the loop is closed, and no task waits
            loop.call_soon_threadsafe(settle, *outcome)

    threading.Thread(target=work, name="zenoh open", daemon=True).start()
    try:
        return await future
    except asyncio.CancelledError:
        if future.done() and not future.cancelled() and future.exception() is None:
            future.result().close()  # it opened just as this task was cancelled
        raise


def _config(endpoints: Endpoints) -> zenoh.Config:
    path = endpoints.config_file
    config = zenoh.Config() if path is None else _read(path)
    plain = zenoh.Config()
    for key, value in endpoints.house_rules().items():
        if path is not None and key in endpoints.by_default and config.get_json(key) != plain.get_json(key):
            continue
        try:
            config.insert_json5(key, strict_json.dumps(value))
        except zenoh.ZError:
            raise FesError(f"not an endpoint like {DEFAULT_ENDPOINT}: {endpoints.shown}") from None
    for key, text in endpoints.own_settings():
        try:
            encoding.check_depth(text)
            config.insert_json5(key, text)
        except (zenoh.ZError, ValueError):
            shown = text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}…"
            raise FesError(f"--cfg {key}:{shown}: no such setting, or its value is not JSON5") from None
    if len(config.get_json("namespace")) > LONGEST_NAMESPACE:
        raise FesError(
            f"Zenoh's setting `namespace` has at most {LONGEST_NAMESPACE} letters: every key begins with it"
        )
    warn_if_exposed(config.get_json("listen/endpoints"))
    return config


def _read(path: Path) -> zenoh.Config:
    """The configuration in a file; raises FesError for one that Zenoh cannot read, or that would end the process."""
    try:
        encoding.check_depth(encoding.read(path))
        return zenoh.Config.from_file(path)
    except OSError as error:
        problem = errors.reason(error, with_file=False)
    except zenoh.ZError as error:
        problem = connection_diagnosis.first_line(str(error))
    except ValueError as error:
        problem = str(error)
    raise TransportError(f"cannot read the Zenoh configuration {path}: {problem}")


def _effective(endpoints: Endpoints, config: zenoh.Config) -> Endpoints:
    """The endpoints in effect: a configuration file or a setting may override the flags. Raises FesError."""

    def given(key: str) -> tuple[str, ...]:
        value = strict_json.loads(config.get_json(key))
        values = value.get(endpoints.mode, []) if isinstance(value, dict) else value
        return tuple(text for text in values if isinstance(text, str))

    return replace(endpoints, connect=given("connect/endpoints"), listen=given("listen/endpoints"))
