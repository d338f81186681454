"""Rules on digits: they depend on the scenario and its seed only, not on the placement of robots or runs."""

from console.backends import inprocess
from console.backends import stacked as stacks
from console.check import commands, recorded
from console.check.case import Case
from console.check.subject import ROBOTS
from console.replay import difference
from console.replay.difference import Difference

ALL = tuple(range(ROBOTS))
CREWS = (ALL[::2], ALL[1::2])
SEEDS = (7, 8, 9)
"""Seeds of the runs in a stack."""

FOLLOWS = "it has other digits, which follows from the failure of `repeat`: correct that first"
"""The breach of a rule on digits by an extension that has other digits at each execution."""


def repeated(case: Case) -> str:
    """A second execution of the recorded run, in the same process."""
    again = case.repetition
    return f"it computes other digits the second time: {again.describe('at first', 'now')}" if again else ""


def alone(case: Case) -> str:
    """Each robot in a crew of its own."""
    return _in_crews(case, tuple((robot,) for robot in ALL))


def crews(case: Case) -> str:
    """The robots in two crews."""
    return _in_crews(case, CREWS)


def _in_crews(case: Case, groups: tuple[tuple[int, ...], ...]) -> str:
    for ids in groups:
        mismatch = recorded.robots(case.scenario, case.moments, ids)
        if mismatch is not None:
            robots = f"robot {ids[0]} alone" if len(ids) == 1 else f"a crew of robots {', '.join(map(str, ids))}"
            return text_of(case, f"{robots} computes other digits than a crew of all", mismatch, "in that crew")
    return ""


def stacked(case: Case) -> str:
    """Several runs in one crew, where a robot's id in the crew is not that in its run."""
    scenarios = [case.subject.scenario(seed) for seed in SEEDS]
    for seed, together in zip(SEEDS, stacks.run(scenarios, "check"), strict=True):
        alone = inprocess.run(case.subject.scenario(seed), "check")
        mismatch = difference.of_summaries(case.scenario.ticks, alone, together)
        if mismatch is not None:
            text = f"with seed {seed} a stacked run and a run alone differ in {mismatch.field}"
            return text if is_repeatable(case) else FOLLOWS
    return ""


def hashing(case: Case) -> str:
    """The run in interpreters that iterate sets in other orders."""
    for hash_seed in (1, 2):
        again = commands.run(case.scenario, *commands.ONE_LOOP, hash_seed=hash_seed)
        mismatch = difference.of_summaries(case.scenario.ticks, case.summary, again)
        if mismatch is not None:
            cause = "do not depend on the order of a set"
            text = f"with PYTHONHASHSEED={hash_seed} a run differs in {mismatch.field}: {cause}"
            return text if is_repeatable(case) else FOLLOWS
    return ""


def processes(case: Case) -> str:
    """The run in processes, over Zenoh."""
    again = {**commands.run(case.scenario, *commands.PROCESSES, hash_seed=3), "model_free": None}
    mismatch = difference.of_summaries(case.scenario.ticks, case.summary, again)
    if mismatch is None:
        return ""
    return f"processes and one loop differ in {mismatch.field}" if is_repeatable(case) else FOLLOWS


def is_repeatable(case: Case) -> bool:
    """True if the extension keeps the rule `repeat`; without that, a difference shows nothing about another rule."""
    return case.repetition is None


def text_of(case: Case, what: str, mismatch: Difference | None, first: str) -> str:
    """The breach of a rule; empty without a mismatch. `first` names the origin of the recorded value."""
    if mismatch is None:
        return ""
    return f"{what}: {mismatch.describe(first, 'now')}" if is_repeatable(case) else FOLLOWS
