"""The rows of the table: the programs that are compared, and the wanted ratios."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import fmean

from bench.against import commands, environments, old, vmas
from bench.against.cores import Core
from bench.against.plan import Plan, Row
from bench.against.programs import NotMeasured
from bench.against.rounds import alternate, ratios
from bench.against.table import Line, Wanted
from bench.speed import compute, lockstep, startup

Side = Callable[[Core], float]
"""A rate or a cost with a core; the other program of a comparison may ignore it."""

SIZES = (100, 1_000, 10_000)
STACK = 20
"""Runs in a stack: as many as a sweep stacks of ten robots."""

OTHER = "other"
"""The side that fes is compared with."""

MOST_SWEEPS = 3
"""Rounds with a whole sweep, at most: each takes minutes."""


def compare(
    plan: Plan, row: Row, ours: Side, theirs: Side, each: bool = False, rounds: int | None = None
) -> list[Line]:
    """A line for each core with the ratios of `ours` to `theirs`, which is measured for each core if `each`."""
    sides: dict[tuple[str, str], Callable[[], float]] = {}
    for core in usable(plan):
        sides[core.choice, "fes"] = partial(ours, core)
        sides[core.choice if each else "", OTHER] = partial(theirs, core)
    measured = alternate(sides, rounds or plan.rounds)
    lines = []
    for core in usable(plan):
        mine, other = measured[core.choice, "fes"], measured[core.choice if each else "", OTHER]
        lines.append(line(row.what, core, row.wanted, mine, other, ratios(mine, other)))
    return lines


def line(what: str, core: Core, wanted: Wanted, ours: list[float], theirs: list[float], values: list[float]) -> Line:
    """A line of the table."""
    return Line(what, core.name, wanted, core.is_compiled, tuple(ours), tuple(theirs), tuple(values))


def usable(plan: Plan) -> list[Core]:
    """The cores that can be measured; raises NotMeasured without any."""
    cores = [core for core in plan.cores if not core.reason]
    if not cores:
        raise NotMeasured(plan.cores[0].reason)
    return cores


def in_lockstep(plan: Plan, row: Row) -> list[Line]:
    """Ten processes against the messages alone."""
    peers, seconds = lockstep.in_range(commands.PAPER), plan.pick(60.0, 20.0)
    return compare(
        plan, row, lambda core: commands.processes(core, seconds), lambda _: commands.messages(peers, seconds)
    )


def in_process(plan: Plan, row: Row) -> list[Line]:
    """Ten robots in one loop against the earlier commit."""
    old.python(plan.folder)
    ticks, skip = round(plan.pick(2000, 1000)), 500
    return compare(
        plan,
        row,
        lambda core: commands.program(core, "paper", ticks, skip),
        lambda _: old.rate(plan.folder, ticks, skip),
    )


def recording(plan: Plan, row: Row) -> list[Line]:
    """A run in process with a log against one without."""
    seconds = plan.pick(60.0, 20.0)
    return compare(
        plan,
        row,
        lambda core: commands.program(core, "summary", seconds, "log"),
        lambda core: commands.program(core, "summary", seconds, "none"),
        each=True,
    )


def moving(plan: Plan, row: Row) -> list[Line]:
    """A thousand robots that move against VMAS's."""
    ticks = round(plan.pick(256, 128))
    return _against_vmas(plan, row, lambda core: commands.program(core, "team", 1000, ticks, 1))


def stack(plan: Plan, row: Row) -> list[Line]:
    """Runs of ten robots as one array program against VMAS's environments of ten."""
    seconds = plan.pick(20.0, 10.0)
    return _against_vmas(plan, row, lambda core: commands.program(core, "stack", STACK, seconds))


def sweep(plan: Plan, row: Row) -> list[Line]:
    """A whole sweep against VMAS."""
    row = replace(row, what=f"{row.what}, {plan.seeds:,} seeds")
    return _against_vmas(plan, row, lambda core: commands.sweep(core, plan.seeds), min(plan.rounds, MOST_SWEEPS))


def _against_vmas(plan: Plan, row: Row, ours: Side, rounds: int | None = None) -> list[Line]:
    environments.vmas(plan.folder)
    steps = round(plan.pick(60, 25))
    return compare(plan, row, ours, lambda _: vmas.rate(plan.folder, steps), rounds=rounds)


def sizes(plan: Plan, row: Row) -> list[Line]:
    """The cost per robot-tick of larger teams against that of a hundred robots, over the same ticks."""
    ticks, lines = round(plan.pick(60, 24)), []
    for core in usable(plan):
        # several runs of a small team, so that each size takes enough time
        sides = {n: partial(commands.program, core, "team", n, ticks, max(1, 2_000 // n)) for n in SIZES}
        costs = {n: [1e6 / rate for rate in rates] for n, rates in alternate(sides, plan.rounds).items()}
        smallest = costs[SIZES[0]]
        for n in SIZES[1:]:
            what = f"{n:,} {row.what}"
            lines.append(line(what, core, row.wanted, costs[n], smallest, ratios(costs[n], smallest)))
    return lines


def ready(plan: Plan, row: Row) -> list[Line]:
    """The processor time until an agent is ready, and its memory, against the earlier commit."""
    old.python(plan.folder)
    sides = {core.choice: partial(commands.started, core) for core in usable(plan)}
    sides[OTHER] = partial(commands.started_old, plan.folder)
    for started in sides.values():
        started()  # the first start stores the bytecode
    measured = alternate(sides, plan.rounds)
    cpu = {side: [fmean(agents.cpu) for agents in rounds] for side, rounds in measured.items()}
    memory = {side: [max(agents.memory) for agents in rounds] for side, rounds in measured.items()}
    size, lines = Wanted(startup.MEMORY, startup.MEMORY, False, " MB"), []
    for core in usable(plan):
        mine, other = cpu[core.choice], cpu[OTHER]
        lines.append(line(row.what, core, row.wanted, mine, other, ratios(mine, other)))
        mine, other = memory[core.choice], memory[OTHER]
        lines.append(line("resident memory of an agent that is ready [MB]", core, size, mine, other, mine))
    return lines


ROWS = (
    Row(
        "lockstep",
        (),
        "lockstep, ten processes, against bare messages [ticks/s]",
        Wanted(lockstep.BUDGET, lockstep.BUDGET_NUMPY),
        in_lockstep,
    ),
    Row(
        "in_process",
        ("old",),
        f"in process, ten robots, against {environments.OLD} [ticks/s]",
        Wanted(4.0, 0.5),
        in_process,
    ),
    Row("recording", (), "in process with a log, against without [ticks/s]", Wanted(0.8, 0.8), recording),
    Row(
        "moving",
        ("vmas",),
        "1,000 moving robots in process, against VMAS flocking [robot-ticks/s]",
        Wanted(2.0, 2.0),
        moving,
    ),
    Row(
        "stack",
        ("vmas",),
        f"{STACK} stacked runs of ten robots, against VMAS flocking [robot-ticks/s]",
        Wanted(1.5, 1.5),
        stack,
    ),
    Row(
        "sweep",
        ("vmas",),
        "fes sweep paper, whole command, against VMAS flocking [robot-ticks/s]",
        Wanted(1.5, 1.5),
        sweep,
    ),
    Row(
        "sizes",
        (),
        f"robots in process, against {SIZES[0]} [µs per robot-tick]",
        Wanted(compute.FLAT, compute.FLAT, at_least=False),
        sizes,
    ),
    Row(
        "ready",
        ("old",),
        f"an agent until it is ready, against {environments.OLD} [s of CPU]",
        Wanted(0.5, 0.5, at_least=False),
        ready,
    ),
)
