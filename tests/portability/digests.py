"""Digests of all cases in one loop, one line each, for comparison with those of another setting.

`python -m tests.portability.digests [--seconds S | --whole] [CASE ...]` needs no more than the dependencies of a run.
A line is `name digest messages=... reports=... summary=...`: SHA-256 of what must be equal to the bit. Lines that
begin with `#` describe this process.
"""

import argparse
import hashlib
import sys

import numpy as np

from console.backends import inprocess
from fes.protocol.report import encode_report
from fes.system import strict_json
from tests.portability import cases, controls
from world.config.scenario import Scenario
from world.execution.recorder import report_period
from world.metrics import report_builder, summary
from world.metrics.collector import MetricsCollector

SHOWN = 16
"""Characters of a hash other than the digest."""


def line(name: str, scenario: Scenario) -> str:
    """The line of a case: its digest, and hashes of its messages, its Reports and its summary."""
    messages, reports = hashlib.sha256(), hashlib.sha256()
    metrics, period = MetricsCollector(scenario), report_period(scenario)
    alive = np.ones(scenario.robots.number, dtype=np.uint8)
    for number, tick in enumerate(inprocess.ticks(scenario)):
        metrics.add(tick.state, tick.twists, tick.telemetry)
        for kind in inprocess.payloads(tick):
            for data in kind:
                messages.update(len(data).to_bytes(4, "little") + data)
        if number % period == 0 or number == scenario.ticks - 1:  # as a log has them, with nothing of the wall clock
            reports.update(encode_report(report_builder.build(metrics, name, alive, 0.0, 0.0)))
    result = summary.summarize(metrics, name, "inprocess", 1.0)
    of_machine = ("arithmetic", "model_free")
    rest = strict_json.dumps({key: value for key, value in result.items() if key not in of_machine}).encode()
    hashes = {"messages": messages, "reports": reports, "summary": hashlib.sha256(rest)}
    return " ".join([name, result["digest"], *(f"{key}={one.hexdigest()[:SHOWN]}" for key, one in hashes.items())])


def main() -> int:
    """Print the lines; returns 0."""
    parser = argparse.ArgumentParser(prog="python -m tests.portability.digests", description=__doc__)
    parser.add_argument("case", nargs="*", help="a built-in scenario, or a variant; by default all")
    parser.add_argument("--seconds", type=float, default=cases.SECONDS, help="simulated time of each case")
    parser.add_argument("--whole", action="store_true", help="the whole length of each case")
    parser.add_argument("--emulated", action="store_true", help="fewer cases, of every kind")
    given = parser.parse_args()
    chosen = given.case or (list(cases.EMULATED) if given.emulated else cases.names())
    if unknown := sorted(set(chosen) - set(cases.names())):
        parser.error(f"no case {unknown[0]}; the cases are {', '.join(cases.names())}")
    for key, value in controls.table().items():
        print(f"# {key}: {value}", flush=True)
    for name in chosen:
        print(line(name, cases.load(name, None if given.whole else given.seconds)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
