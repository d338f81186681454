"""The page of the extensions, from the protocols of `fes.extension` and the values that they get and return."""

import ast
import inspect
import re
import textwrap
from typing import Any

from docs.generators.markdown import code, prose, table
from fes.arithmetic import elementary, sums
from fes.arrays import edges
from fes.extension import context, controllers, kinds, neighborhood, protocols
from fes.extension.kinds import Kind
from fes.model import beacon_slots, config, contacts, sensing
from world.metrics import tick_truth
from world.simulation import channel, truth

TITLE = "Extensions"
INTRODUCTION = """The interface for your own laws, neighbor rules, channels, dynamics and metrics. Any class that has
the members of a kind is an extension of this kind. Import names from `fes.extension`. The
[tutorial](../tutorial/own-law.md) writes three, the page of [built-in extensions](built-in.md) lists those that come
with `fes`, and `fes check` shows whether one keeps the rules.

A *crew* is the robots of one process, as rows of the same arrays; the [glossary](glossary.md) has other terms.
Shapes: n robots, m contacts, l links, u pairs of linked robots, q statistics, b bytes, k learnt numbers, j details.
Arrays must not be written to."""

ALL_KINDS = """Each class has an attribute `Parameters`, a subclass of `fes.extension.Table`, and a constructor
`(parameters, context)`. A controller gets a `ControllerContext`. The other laws and a neighbor rule get a
`LawContext`, and a channel, dynamics or a metric gets a `WorldContext`. A number or a tuple of names that a class
does not state is 0 or empty. A controller, formation law or seeking law with `knows_channel = True` is told the
channel."""

PROTOCOLS: tuple[tuple[Kind, str, tuple[type, ...]], ...] = (
    (kinds.CONTROLLER, "`[robots] controller`", (controllers.Controller,)),
    (kinds.FORMATION, "`[formation] law`", (protocols.FormationLaw,)),
    (kinds.SEEKING, "`[seeking] use`", (protocols.SeekingLaw,)),
    (kinds.RULE, "`[formation] rule`", (protocols.NeighborRule,)),
    (kinds.CHANNEL, "`[channel] model`", (protocols.Channel, protocols.PairChannel)),
    (kinds.DYNAMICS, "`[robots] dynamics`", (protocols.Dynamics,)),
    (kinds.METRIC, "`[[metric]] use`", (protocols.Metric,)),
)
"""Each kind, its place in a scenario, and its protocols."""

VALUES: tuple[type, ...] = (
    controllers.RobotView, controllers.Neighbor, controllers.Action, controllers.Pull, controllers.Twist,
    neighborhood.Neighborhood, neighborhood.LinkGeometry, neighborhood.Entry, contacts.Contacts, beacon_slots.Slots,
    protocols.Formed, protocols.Published, controllers.ControllerContext, context.LawContext, context.WorldContext,
    context.Draws, context.KnownChannel, config.ObjectiveConfig, edges.Edges, edges.Transition, tick_truth.TickTruth,
    truth.State, channel.Radio, sensing.Telemetry,
)  # fmt: skip
"""Arguments and results of extensions."""

SHOWN: dict[type, tuple[str, ...]] = {
    edges.Edges: (
        "ids", "rows", "peers", "robots", "keys", "reverse", "mutual", "undirected", "counts", "find", "sum",
        "first_smallest", "smallest", "select", "carry", "after",
    ),
    truth.State: ("tick", "poses", "channel", "radio", "present", "since", "sent", "decoded"),
    channel.Radio: (
        "edges", "age", "reception", "sent", "decoded", "probability", "outage_sum", "gap", "longest_gap",
    ),
}  # fmt: skip
"""Members for extensions, of classes that have further ones."""

FUNCTIONS = """`from fes.extension import elementary, sums` gives functions with the same bits on every machine.
[Digits](../explanation/digits.md#in-an-extension) states when they are needed."""


def page() -> list[str]:
    """The lines of the page, without its title."""
    lines = ["## All kinds", "", ALL_KINDS, ""]
    rows = [[kind.name, place, code(kind.group)] for kind, place, _ in PROTOCOLS]
    lines += table(["kind", "place in a scenario", "group of entry points"], rows)
    for kind, _, alternatives in PROTOCOLS:
        lines += [f"## {kind.name.capitalize()}", ""]
        for protocol in alternatives:
            lines += _described(protocol)
    lines += ["## Values", ""]
    for value in VALUES:
        lines += [f"### `{value.__name__}`", "", *_described(value)]
    return [*lines, "## Functions", "", FUNCTIONS, "", *_functions()]


def _functions() -> list[str]:
    """A table of the elementary functions and of the sums."""
    named = [("elementary", elementary.NUMPY[name]) for name in elementary.__all__]
    named += [("sums", function) for _, function in inspect.getmembers(sums, inspect.isfunction)]
    rows = []
    for module, function in named:
        [definition] = ast.parse(inspect.getsource(function)).body
        assert isinstance(definition, ast.FunctionDef)
        meaning = (inspect.getdoc(function) or "").partition(">>>")[0].strip()
        rows.append([code(f"{module}.{_signature(definition)}"), prose(meaning)])
    return table(["function", "meaning"], rows)


def _described(kind: type) -> list[str]:
    """The docstring of a class, and a table of its members."""
    text = (inspect.getdoc(kind) or "").split("\n\n")
    rows = [[code(member), prose(meaning)] for member, meaning in _shown(kind)]
    return [*(line for part in text for line in (prose(part), "")), *table(["member", "meaning"], rows)]


def _shown(kind: type) -> list[tuple[str, str]]:
    """The members of a class that the page describes, without examples."""
    members = [(member, meaning.partition(">>>")[0].strip()) for member, meaning in _members(kind)]
    if kind not in SHOWN:
        return members
    named = {re.split(r"\W", member, maxsplit=1)[0]: (member, meaning) for member, meaning in members}
    return [named[name] for name in SHOWN[kind]]


def _members(kind: type) -> list[tuple[str, str]]:
    """Each attribute, property and method in the body of a class; attributes may share the docstring after them."""
    [definition] = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(definition, ast.ClassDef)
    members: list[tuple[str, str]] = []
    waiting: list[str] = []
    for node in definition.body[1:]:
        if isinstance(node, ast.FunctionDef) and (not node.name.startswith("_") or node.name == "__call__"):
            members += [(name, "") for name in waiting] + [(_signature(node), ast.get_docstring(node) or "")]
            waiting = []
        elif isinstance(node, ast.AnnAssign):
            waiting.append(ast.unparse(node))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and waiting:
            members.append((", ".join(waiting), str(node.value.value)))
            waiting = []
    return members + [(name, "") for name in waiting]


def _signature(node: ast.FunctionDef) -> str:
    returned = ast.unparse(node.returns) if node.returns is not None else "None"
    names: list[Any] = [getattr(decorator, "id", "") for decorator in node.decorator_list]
    if "property" in names or "cached_property" in names:
        return f"{node.name}: {returned}"
    arguments = ast.unparse(node.args).removeprefix("self").removeprefix(", ")
    return f"{node.name}({arguments}) -> {returned}"
