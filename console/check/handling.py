"""Rules on the handling of values: results, inputs, state, clocks and random numbers."""

import math
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from console.check import frozen, recorded, sources
from console.check.case import Case
from console.check.digits import ALL, text_of
from fes.errors import FesError
from world.config.scenario import Scenario
from world.execution import snapshot
from world.execution.snapshot import Snapshot


def interface(case: Case) -> str:
    """The methods of the class, and its parameters: a scenario that uses it is valid."""
    _ = case.scenario
    return ""


def values(case: Case) -> str:
    """The results of the extension during a run; the registry checks shapes and types at each call."""
    for moment in case.moments:
        for name, numbers in moment.numbers.items():
            wrong = [key for key, value in numbers.items() if value is not None and not math.isfinite(value)]
            if wrong:
                return f"result must be finite or None, got {name}.{wrong[0]} = {numbers[wrong[0]]}"
    return ""


def inputs(case: Case) -> str:
    """A run in which every array is read-only while the extension has it."""
    try:
        if case.subject.is_law:
            mismatch = recorded.robots(case.scenario, case.moments, ALL, frozen.robots)
        else:
            mismatch = recorded.world(case.scenario, case.moments, frozen.parts)
    except FesError as error:
        if frozen.READ_ONLY not in str(error):
            raise
        method = str(error).partition(f"{case.subject.title}: ")[2].partition(":")[0]
        return f"{method} writes to an array of its inputs or of its state, instead of returning a new one"
    return text_of(case, "it computes other digits from inputs that are read-only", mismatch, "from others")


def state(case: Case) -> str:
    """A run whose state is pickled in the middle, where new objects continue from it."""
    if case.subject.is_law:
        mismatch = recorded.robots(case.scenario, case.moments, ALL, pause=_pickled)
    else:
        mismatch = recorded.world(case.scenario, case.moments, pause=lambda pair: _checkpointed(case.scenario, *pair))
    what = "a run resumed from its state has other digits: keep all memory in the state"
    return text_of(case, what, mismatch, "uninterrupted")


def restart(case: Case) -> str:
    """A robot that rejoins, as one that forgets and as a new one."""
    for robot in ALL:
        mismatch = recorded.robots(case.scenario, case.moments, (robot,), renews=True)
        if mismatch is not None:
            return text_of(case, "a robot that forgets differs from a new one", mismatch, "after `forget`")
    return ""


def clock(case: Case) -> str:
    """A run in which clocks raise."""
    return _sources(case, _is_clock, "it reads a clock")


def randomness(case: Case) -> str:
    """A run in which global random numbers raise."""
    what = "it takes random numbers that are not of its context"
    return _sources(case, lambda name: not _is_clock(name), what)


def _is_clock(name: str) -> bool:
    return name.startswith(("time.", "datetime."))


def _sources(case: Case, concerns: Callable[[str], bool], what: str) -> str:
    package = case.subject.loaded.__module__.partition(".")[0]
    try:
        with sources.forbidden(package, concerns) as calls:
            recorded.record(case.scenario)
    except FesError:
        if not calls:
            raise
    return f"{what}: {calls[0]}" if calls else ""


def _pickled(state: Any) -> Any:
    """A copy of a state, by pickle; raises FesError."""
    try:
        return pickle.loads(pickle.dumps(state, protocol=5))
    except Exception as error:  # the state is that of anybody's code
        raise FesError(f"its state cannot be pickled: {type(error).__name__}: {error}") from None


def _checkpointed(scenario: Scenario, state: Any, metrics: Any) -> Any:
    """The state of a world and its metrics, as a checkpoint gives them back; raises FesError."""
    now = Snapshot(
        number=0, name="check", run="check", scenario=scenario, changed_scenario=scenario, state=state,
        metrics=metrics, hosts={}, renewed=[], excluded={}, beacons={}, log=None, elapsed=0.0, checksum=0,
    )  # fmt: skip
    with tempfile.TemporaryDirectory(prefix="fes-check-") as folder:
        path = Path(folder) / "state"
        path.write_bytes(snapshot.pack(now))
        again = snapshot.read(path)
    return again.state, again.metrics
