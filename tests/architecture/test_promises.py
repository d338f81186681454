"""docs/explanation/reliability.md names tests that exist, and its figures are those of the code."""

import ast
from re import findall

import pytest

from agents.runtime import outbox
from console.backends import process_group
from console.connect import observer
from fes.transport import bus, drop_log, inbox
from fes.transport.endpoints import Endpoints
from tests.support.paths import ROOT
from world.execution import barrier, checkpoint, hosting, live_tick
from world.metrics import deadlines
from world.server import audit, live, lockstep

TEXT = " ".join((ROOT / "docs" / "explanation" / "reliability.md").read_text(encoding="utf-8").split())
"""On one line."""


def test_every_test_that_the_docs_name_exists() -> None:
    paths = list((ROOT / "tests").rglob("test_*.py"))
    files = {path.stem for path in paths}
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in paths]
    functions = {
        node.name for tree in trees for node in tree.body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    named = findall(r"\b(test_\w+)(\.py)?", TEXT)
    assert len(named) > 60
    missing = [name for name, file in named if name not in (files if file else functions)]
    assert not missing


SESSION_LEASE = float(str(Endpoints("client", ()).house_rules()["transport/link/tx/lease"])) / 1000.0  # s
FIGURES = [
    f"after {barrier.ANSWER_TIMEOUT:g} s without an answer it is excluded",
    f"the world waits up to {lockstep.RETURN_TIMEOUT:g} s for a robot that is due",
    f"in lockstep it waits {lockstep.RETURN_TIMEOUT:g} s, then ends with one line",
    f"the world asks again after {barrier.RESEND_AFTER:g} s, {2 * barrier.RESEND_AFTER:g} s, ...",
    f"is leased the lowest free robot, for {hosting.LEASE:g} s",
    f"The world waits {hosting.RESUME_TIMEOUT:g} s for a robot that died meanwhile",
    f"the next checkpoint, {checkpoint.PERIOD:g} s of wall clock later",
    f"if the last command is older than {deadlines.COMMAND_TIMEOUT:g} s, the robot stops",
    f"A robot that is silent for {live_tick.HANG_TIMEOUT:g} s is excluded",
    f"the first {live.WARM_UP} ticks, and those after a world resumed",
    f"its session is gone with its lease of {SESSION_LEASE:g} s",
    f"its world has {process_group.CLOSING:g} s to write them",
    f"over TLS {audit.KINDS_PER_NAME} per certificate",
    f"{bus.MAX_QUERIES} of one client wait for one handler",
    f"(Zenoh's ring) | {bus.MAILBOX} samples",
    f"`agents.runtime.outbox`, published beacons | {outbox.REMEMBERED} ticks",
    f"cut to {drop_log.LONGEST_LINE} characters",
    f"at most {drop_log.MAX_KINDS} kinds are distinguished",
    f"{inbox.LIMIT:,} messages, {inbox.LIMIT_BYTES >> 20} MiB",
    f"`console.connect.observer`, reports | {observer.MAX_WAITING} |",
]
"""Tests of these promises use shorter times."""


@pytest.mark.parametrize("promise", FIGURES)
def test_a_figure_that_is_promised_is_that_of_the_code(promise: str) -> None:
    assert promise in TEXT
