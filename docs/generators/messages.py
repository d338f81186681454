"""The page of key expressions and messages, from the docstrings of `fes.protocol`."""

import ast
import inspect
import re
from types import ModuleType

from docs.generators.markdown import code, prose, table
from fes.model import sensing
from fes.protocol import channel_change, keys, messages, report, robot_control, robot_report, wire, world_info

TITLE = "Messages and keys"
MODULES = (messages, report, world_info, channel_change, robot_report, robot_control)
CALLED = {"WorldInfo": "About", "ParameterChange": "Change", "ChangeResult": "Effect"}
"""Classes whose message has another name on the wire."""


def page() -> list[str]:
    """The lines of the page, without its title."""
    lines = [
        f"This page describes version {wire.PROTOCOL} of the wire protocol. A payload is a MessagePack array:",
        "the version, then the fields in the order of the tables. Arrays of numbers are little-endian bytes.",
        "",
        "## Keys",
        "",
        "`<run>` is the name of the run, `<i>` a robot, and `<ids>` the robots of one agent, such as `0-4`.",
        "",
        *_keys(),
        "## Bounds",
        "",
        *_bounds(),
        "## Messages",
        "",
    ]
    for module in MODULES:
        lines += _messages(module)
    return lines


def _keys() -> list[str]:
    """The table of keys in the docstring of its module."""
    rows = [
        [part.strip() for part in line.strip("|").split("|")]
        for line in (inspect.getdoc(keys) or "").splitlines()
        if line.startswith("| fes/")
    ]
    heads = ["key", "payload", "from -> to", "rate"]
    return table(heads, ([code(key), payload, way, rate] for key, payload, way, rate in rows))


def _bounds() -> list[str]:
    rows = [
        ["robots of a run", f"{keys.MAX_ROBOTS:,}"],
        ["a number in a beacon", f"±{sensing.MAX_NUMBER:g}"],
        ["a twist in a command", f"±{sensing.MAX_TWIST:g} m/s, rad/s"],
        ["statistics of a beacon", f"{sensing.MAX_STATISTICS}"],
        ["peers in a RobotReport", f"{robot_report.MAX_PEERS:,}"],
        ["reason of a gate", f"{robot_control.LONGEST_REASON} characters"],
        ["value in a Change", f"{channel_change.LONGEST:,} characters of JSON"],
    ]
    return table(["quantity", "bound"], rows)


def _messages(module: ModuleType) -> list[str]:
    lines: list[str] = []
    for node in ast.parse(inspect.getsource(module)).body:
        if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
            continue
        name = CALLED.get(node.name, node.name)
        lines += [f"### {name}", "", prose(ast.get_docstring(node) or ""), ""]
        lines += [f"Python: `{module.__name__}.{node.name}`", ""]
        lines += table(["field", "type", "meaning"], _fields(node))
    return lines


def _fields(node: ast.ClassDef) -> list[list[str]]:
    """Name, type and docstring of each field of a message; the docstring may be empty."""
    rows = []
    following = [*node.body[1:], None]
    for statement, after in zip(node.body, following, strict=True):
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
            text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
            rows.append([code(statement.target.id), code(ast.unparse(statement.annotation)), prose(str(text))])
    return rows


def names() -> set[str]:
    """The messages that are payloads in the table of keys."""
    payloads = " ".join(line.split("|")[2] for line in _keys()[2:] if line)
    return set(re.findall(r"\b[A-Z][a-z]+\b", payloads))
