"""Who listens, who is alive on a run, and what its world says of itself. Looking disturbs nobody: an observer's
session asks the router which tokens stand, and the world who it is."""

import asyncio
import re
import socket
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import NamedTuple

from console.doctor.finding import Finding, failed, ok, warning
from fes.errors import FesError, MessageError, Rejected, TransportError, Unavailable, reason
from fes.protocol import keys, world_info
from fes.protocol.wire import PROTOCOL
from fes.protocol.world_info import WorldInfo
from fes.transport import bus, health
from fes.transport.bus import Bus
from fes.transport.connection_diagnosis import SLOW
from fes.transport.endpoints import DEFAULT_ENDPOINT, Endpoints

PATIENCE = 2.0
"""How long each question may take [s]."""

LARGE_SKEW = 0.1
"""Clocks that differ by more [s] make the logs of two machines hard to put side by side; the lockstep needs none."""

LOCAL = ("127.", "localhost", "[::1]")
_TCP = re.compile(r"[a-z]+/(\S+):(\d{1,5})(\?\S*)?")


def port(endpoint: str, world: bool) -> Finding:
    """Whether a world can listen at an endpoint of the loopback interface, or a `world` does already."""
    number = int(endpoint.rpartition(":")[2])
    try:
        with socket.create_server(("127.0.0.1", number)):
            return ok("port", f"{endpoint} is free: a world can listen there")
    except OSError as error:
        if world:
            return ok("port", f"{endpoint}: a world listens there")
        remedy = f"if it is no world of yours: fes-world -l tcp/127.0.0.1:PORT (ss -ltnp sport = :{number} names it)"
        return warning("port", f"{endpoint}: {reason(error).lower()}", remedy)


def is_default(endpoint: str) -> bool:
    """Whether an endpoint has the default address, in plain or over TLS."""
    return endpoint.partition("/")[2] == DEFAULT_ENDPOINT.partition("/")[2]


def exposure(endpoint: str, table: str | None = None) -> Finding:
    """Whether what listens at an endpoint listens on the loopback interface only; `table` as in /proc/net/tcp."""
    check, found = "loopback only", _TCP.fullmatch(endpoint)
    if found is None:
        return ok(check, f"{endpoint} is no network")
    if not found[1].startswith(LOCAL):
        remedy = "robots on other machines need this; else listen on 127.0.0.1, or use tls with certificates"
        return warning(check, f"{endpoint} is on a network: whoever is on it may speak", remedy)
    if any(address != "0100007F" for address in _listening(int(found[2]), table)):
        remedy = f"start the world with -l {DEFAULT_ENDPOINT}"
        return warning(check, f"what listens on port {found[2]} does so on every interface", remedy)
    return ok(check, f"{endpoint}; multicast scouting is off")


def _listening(port: int, table: str | None) -> Iterator[str]:
    """The addresses, in hexadecimal, on which somebody listens at a port."""
    try:
        found = health.sockets([Path("/proc/net/tcp").read_text(encoding="ascii") if table is None else table])
    except OSError:
        return  # another system than Linux
    yield from (one.address for one in found if one.state == health.LISTEN and one.port == port)


class Answer(NamedTuple):
    """What a world said of itself, and when it was asked and heard [s since 1970]."""

    asked: float
    heard: float
    world_info: WorldInfo


Silence = MessageError | Unavailable | Rejected


async def examine(endpoints: Endpoints, run: str, wanted: bool) -> tuple[list[Finding], int | None]:
    """All that can be seen of a run from outside, and how many robots it has.

    It fails where none can be seen only if the run is `wanted`: who names no run may have none. It looks for
    other runs only without certificates: with them nobody may.
    """
    try:
        async with _opened(endpoints) as opened:
            standing = await opened.liveliness_get(keys.tree(run), PATIENCE)
            others = [] if endpoints.security else await opened.liveliness_get(keys.world_alive("*"), PATIENCE)
            answer = await _ask(opened, run) if keys.world_alive(run) in standing else None
    except (TransportError, TimeoutError, Unavailable) as error:
        said = str(error) or f"{endpoints.shown} is open, but does not speak Zenoh, {SLOW}"
        if wanted:
            return [failed("endpoint", said, remedy(said))], None
        if "nobody listens" in said:
            return [ok("endpoint", f"{said}: no run goes on")], None
        return [warning("endpoint", said, remedy(said))], None
    except FesError as error:
        return [refused(error)], None
    robots = answer.world_info.robots if isinstance(answer, Answer) else None
    found = [ok("endpoint", f"{endpoints.shown} answers"), alive(run, standing, others, robots, wanted)]
    return found + (list(said_by(answer)) if answer is not None else []), robots


def refused(error: FesError) -> Finding:
    """The finding that no run can be looked for with the flags that were given."""
    said = str(error)
    keyed = "--keys" in said or "certificate" in said
    return failed("endpoint", said, remedy(said) if keyed else "fes doctor --help says what its flags take")


def remedy(said: str) -> str:
    """What to do where no session opened, after what is `said` of that."""
    again = "look again (kill -CONT PID has a world go on that is stopped)"
    if "--keys" in said:
        certified = "fes doctor -e tls/HOST:PORT --keys DIR, with ca.crt and observer.{crt,key} in DIR"
        return f"{certified}; or {again}" if SLOW in said else certified
    if SLOW in said:
        return again
    if "does not resolve" in said:
        return "correct the name, or name the address of the world's machine: -e tcp/ADDRESS:PORT"
    if "certificate" in said:
        return "certificates in date, of the authority of that world (fes keys list), and one of its names for HOST"
    return "start fes-world or fes run, or name its endpoint with -e"


@asynccontextmanager
async def _opened(endpoints: Endpoints) -> AsyncIterator[Bus]:
    """A bus, within a bounded time also where something listens that does not speak Zenoh."""
    opening = bus.opened(endpoints)
    async with asyncio.timeout(2 * PATIENCE):
        opened = await opening.__aenter__()
    try:
        yield opened
    finally:
        await opening.__aexit__(None, None, None)


async def _ask(opened: Bus, run: str) -> Answer | Silence:
    """What the world says of itself, or why it says nothing."""
    asked = time.time()
    try:
        payload = await opened.get(keys.about(run), b"", PATIENCE)
        return Answer(asked, time.time(), world_info.decode_world_info(payload))
    except (MessageError, Unavailable, Rejected) as error:
        return error


def alive(run: str, standing: list[str], others: list[str], robots: int | None, wanted: bool) -> Finding:
    """Who is there, by the liveliness tokens that stand: of this run, and the worlds of all runs."""
    here = sorted({robot for key in standing if (robot := keys.robot_of(key)) is not None})
    runs = sorted({key.split("/")[1] for key in others} - {run})
    elsewhere = f"; worlds of other runs: {', '.join(runs)}" if runs else ""
    if keys.world_alive(run) not in standing:
        seen = f"no world of run '{run}', robots: {spans(here) or 'none'}{elsewhere}"
        remedy = f"--run {runs[0]}" if runs else "start fes-world with the same --run and endpoint"
        return (failed if wanted else warning)("alive", seen, remedy)
    if sum(key.startswith(keys.claim(run, "")) for key in standing) > 1:
        return failed("alive", f"more than one world of run '{run}'", "end all but one of them")
    missing = sorted(set(range(robots or (max(here, default=-1) + 1))) - set(here))
    seen = f"world of run '{run}', robots {spans(here) or 'none'} of {robots or '?'}{elsewhere}"
    if missing:
        waits = "before its first tick a run waits for all, and later those without an agent stand still"
        return warning("alive", seen, f"fes-agent --id {spans(missing)}: {waits}")
    if robots is None:
        return warning("alive", seen, "the world does not say how many robots it has: see its version")
    return ok("alive", seen)


def said_by(answer: Answer | Silence) -> Iterator[Finding]:
    """Versions and clock of a world, beside our own."""
    same = "install the same version of fes here and there"
    if isinstance(answer, MessageError) and world_info.speaks_otherwise(answer):
        yield failed("version", str(answer), same)
        return
    if not isinstance(answer, Answer):
        yield warning("version", f"the world does not say its version ({answer})", same)
        return
    own, other = world_info.of_this_process(1), answer.world_info
    seen = f"protocol {PROTOCOL}, fes {other.package}, zenoh {other.zenoh}"
    if (own.package, own.zenoh) != (other.package, other.zenoh):
        yield warning("version", f"{seen} there; fes {own.package}, zenoh {own.zenoh} here", same)
    else:
        yield ok("version", f"{seen}, here and there")
    skew, known = other.clock - (answer.asked + answer.heard) / 2.0, (answer.heard - answer.asked) / 2.0
    seen = f"the world's is {1e3 * skew:+.1f} ms from ours, known to {1e3 * known:.1f} ms"
    if abs(skew) - known > LARGE_SKEW:  # a slow answer says little, and is no skew
        yield warning("world's clock", seen, "synchronize both machines with NTP, to read their logs side by side")
    else:
        yield ok("world's clock", seen)


def spans(ids: list[int]) -> str:
    """Ascending ids as a person reads them.

    >>> spans([0, 1, 2, 5, 7, 8])
    '0-2, 5, 7-8'
    """
    known = set(ids)
    starts, ends = ([robot for robot in ids if robot + step not in known] for step in (-1, 1))
    return ", ".join(str(low) if low == high else f"{low}-{high}" for low, high in zip(starts, ends, strict=True))
