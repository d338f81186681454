"""Checks of the network: ports, liveliness tokens of a run, and the world's description of itself.

They disturb no run: an observer's session queries the router for tokens, and the world for its description.
"""

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
"""Longest time of each query [s]."""

LARGE_SKEW = 0.1
"""Difference of two clocks [s] beyond which logs of two machines are hard to compare; lockstep needs no clock."""

LOCAL = ("127.", "localhost", "[::1]")
_TCP = re.compile(r"[a-z]+/(\S+):(\d{1,5})(\?\S*)?")


def port(endpoint: str, world: bool) -> Finding:
    """The port of an endpoint on the loopback interface: free, or taken by a `world`."""
    number = int(endpoint.rpartition(":")[2])
    try:
        with socket.create_server(("127.0.0.1", number)):
            return ok("port", f"{endpoint} is free: a world can listen there")
    except OSError as error:
        if world:
            return ok("port", f"{endpoint}: a world listens there")
        remedy = f"if that is not your world: fes-world -l tcp/127.0.0.1:PORT (ss -ltnp sport = :{number} names it)"
        return warning("port", f"{endpoint}: {reason(error).lower()}", remedy)


def is_default(endpoint: str) -> bool:
    """True if an endpoint has the default address, over TCP or TLS."""
    return endpoint.partition("/")[2] == DEFAULT_ENDPOINT.partition("/")[2]


def exposure(endpoint: str, table: str | None = None) -> Finding:
    """The interfaces on which a program listens at an endpoint; `table` has the format of /proc/net/tcp."""
    check, match = "loopback only", _TCP.fullmatch(endpoint)
    if match is None:
        return ok(check, f"{endpoint} is not on a network")
    if not match[1].startswith(LOCAL):
        remedy = "robots on other machines need this; else listen on 127.0.0.1, or use tls with certificates"
        return warning(check, f"{endpoint} is on a network, and every host there can take part", remedy)
    if any(address != "0100007F" for address in _listening(int(match[2]), table)):
        remedy = f"start the world with -l {DEFAULT_ENDPOINT}"
        return warning(check, f"the program at port {match[2]} listens on every interface", remedy)
    return ok(check, f"{endpoint}; multicast scouting is off")


def _listening(port: int, table: str | None) -> Iterator[str]:
    """The addresses, in hexadecimal, on which programs listen at a port."""
    try:
        entries = health.sockets([Path("/proc/net/tcp").read_text(encoding="ascii") if table is None else table])
    except OSError:
        return  # another system than Linux
    yield from (entry.address for entry in entries if entry.state == health.LISTEN and entry.port == port)


class Answer(NamedTuple):
    """A world's description of itself, with the times of the query and of the reply [s since 1970]."""

    query_time: float
    reply_time: float
    world_info: WorldInfo


Silence = MessageError | Unavailable | Rejected


async def examine(endpoints: Endpoints, run: str, is_requested: bool) -> tuple[list[Finding], int | None]:
    """All checks of a run, and its number of robots.

    A missing run is a failure only if the user requested it. Without certificates the checks include other runs; with
    them no role may see those.
    """
    try:
        async with _opened(endpoints) as session:
            tokens = await session.liveliness_get(keys.tree(run), PATIENCE)
            others = [] if endpoints.security else await session.liveliness_get(keys.world_alive("*"), PATIENCE)
            answer = await _query(session, run) if keys.world_alive(run) in tokens else None
    except (TransportError, TimeoutError, Unavailable) as error:
        problem = str(error) or f"{endpoints.shown} is open, but does not speak Zenoh, {SLOW}"
        if is_requested:
            return [failed("endpoint", problem, remedy(problem))], None
        if "nothing listens" in problem:
            return [ok("endpoint", f"{problem}: no run is running")], None
        return [warning("endpoint", problem, remedy(problem))], None
    except FesError as error:
        return [invalid_flags(error)], None
    robots = answer.world_info.robots if isinstance(answer, Answer) else None
    findings = [ok("endpoint", f"{endpoints.shown} answers"), alive(run, tokens, others, robots, is_requested)]
    return findings + (list(versions(answer)) if answer is not None else []), robots


def invalid_flags(error: FesError) -> Finding:
    """A finding on flags with which no session can open."""
    problem = str(error)
    is_about_keys = "--keys" in problem or "certificate" in problem
    return failed("endpoint", problem, remedy(problem) if is_about_keys else "fes doctor --help describes its flags")


def remedy(problem: str) -> str:
    """The remedy for a `problem` with which no session opened."""
    again = "check again (kill -CONT PID resumes a suspended world)"
    if "--keys" in problem:
        certified = "fes doctor -e tls/HOST:PORT --keys DIR, with ca.crt and observer.{crt,key} in DIR"
        return f"{certified}; or {again}" if SLOW in problem else certified
    if SLOW in problem:
        return again
    if "does not resolve" in problem:
        return "correct the name, or name the address of the world's machine: -e tcp/ADDRESS:PORT"
    if "certificate" in problem:
        return (
            "use valid certificates of the world's authority (fes keys list), and a HOST that its certificate names"
        )
    return "start fes-world or fes run, or name its endpoint with -e"


@asynccontextmanager
async def _opened(endpoints: Endpoints) -> AsyncIterator[Bus]:
    """A bus; opening it takes bounded time, also if the program that listens does not speak Zenoh."""
    opening = bus.opened(endpoints)
    async with asyncio.timeout(2 * PATIENCE):
        session = await opening.__aenter__()
    try:
        yield session
    finally:
        await opening.__aexit__(None, None, None)


async def _query(session: Bus, run: str) -> Answer | Silence:
    """The world's description of itself, or the error of the query."""
    query_time = time.time()
    try:
        payload = await session.get(keys.about(run), b"", PATIENCE)
        return Answer(query_time, time.time(), world_info.decode_world_info(payload))
    except (MessageError, Unavailable, Rejected) as error:
        return error


def alive(run: str, tokens: list[str], others: list[str], robots: int | None, is_requested: bool) -> Finding:
    """The world and the robots of a run by their liveliness `tokens`, and the worlds of `others`."""
    present = sorted({robot for key in tokens if (robot := keys.robot_of(key)) is not None})
    runs = sorted({key.split("/")[1] for key in others} - {run})
    elsewhere = f"; worlds of other runs: {', '.join(runs)}" if runs else ""
    if keys.world_alive(run) not in tokens:
        if gates := [robot for robot in present if keys.gate_alive(run, robot) in tokens]:
            return _real_robots(run, gates, [robot for robot in present if keys.robot_alive(run, robot) in tokens])
        seen = f"no world of run '{run}', robots: {spans(present) or 'none'}{elsewhere}"
        remedy = f"--run {runs[0]}" if runs else "start fes-world with the same --run and endpoint"
        return (failed if is_requested else warning)("alive", seen, remedy)
    if sum(key.startswith(keys.claim(run, "")) for key in tokens) > 1:
        return failed("alive", f"more than one world of run '{run}'", "end all but one of them")
    missing = sorted(set(range(robots or (max(present, default=-1) + 1))) - set(present))
    seen = f"world of run '{run}', robots {spans(present) or 'none'} of {robots or '?'}{elsewhere}"
    if missing:
        effect = "the first tick waits for all robots; later, robots without an agent stand still"
        return warning("alive", seen, f"fes-agent --id {spans(missing)}: {effect}")
    if robots is None:
        return warning("alive", seen, "the world does not report its number of robots: compare its version")
    return ok("alive", seen)


def _real_robots(run: str, gates: list[int], agents: list[int]) -> Finding:
    """The gates and the agents of real robots, which need no world."""
    seen = f"real robots of run '{run}': gates {spans(gates)}, agents {spans(agents) or 'none'}"
    if gates == agents:
        return ok("alive", seen)
    return warning("alive", seen, "a gate without an agent holds its robot, and an agent without a gate has no body")


def versions(answer: Answer | Silence) -> Iterator[Finding]:
    """Versions and clock of a world, compared with those of this machine."""
    same = "install the same version of fes on both machines"
    if isinstance(answer, MessageError) and world_info.speaks_otherwise(answer):
        yield failed("version", str(answer), same)
        return
    if not isinstance(answer, Answer):
        yield warning("version", f"the world does not report its version ({answer})", same)
        return
    own, remote = world_info.of_this_process(1), answer.world_info
    seen = f"protocol {PROTOCOL}, fes {remote.package}, zenoh {remote.zenoh}"
    if (own.package, own.zenoh) != (remote.package, remote.zenoh):
        yield warning("version", f"the world has {seen}; this machine has fes {own.package}, zenoh {own.zenoh}", same)
    else:
        yield ok("version", f"{seen}, on both sides")
    skew, uncertainty = (
        remote.clock - (answer.query_time + answer.reply_time) / 2.0,
        (answer.reply_time - answer.query_time) / 2.0,
    )
    seen = f"the world's is {1e3 * skew:+.1f} ms from ours, within {1e3 * uncertainty:.1f} ms"
    if abs(skew) - uncertainty > LARGE_SKEW:  # the delay of a slow answer is not a skew
        yield warning("world's clock", seen, "synchronize both machines with NTP, to compare their logs")
    else:
        yield ok("world's clock", seen)


def spans(ids: list[int]) -> str:
    """Ascending ids as text.

    >>> spans([0, 1, 2, 5, 7, 8])
    '0-2, 5, 7-8'
    """
    known = set(ids)
    starts, ends = ([robot for robot in ids if robot + step not in known] for step in (-1, 1))
    return ", ".join(str(low) if low == high else f"{low}-{high}" for low, high in zip(starts, ends, strict=True))
