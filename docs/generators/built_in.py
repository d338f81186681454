"""The page of the built-in extensions: name, purpose and parameters of each, from the registry and the classes."""

import re
from typing import Any

from docs.generators.markdown import code, prose, table
from fes.extension import kinds, registry
from fes.extension.context import SeededDraws, WorldContext
from fes.extension.kinds import Kind
from fes.extension.protocols import NoParameters
from fes.model.config import ObjectiveConfig
from fes.model.table import Table
from fes.settings.schema import attribute_docstrings

TITLE = "Built-in extensions"
INTRODUCTION = """The laws, neighbor rules, channels, dynamics and metrics that come with `fes`. A scenario chooses
one by its name. Its parameters stand beside the name, such as `law = { use = "voronoi", gain = 2.0 }`. The page
of [extensions](extensions.md) shows how to write your own. There is no built-in controller."""

CHOSEN = {
    "formation law": "`[formation] law`. The limits of speed and the gains of (6), (7) are fields of `[formation]`.",
    "seeking law": "`[seeking] index` for the first four, and `[seeking] use` for the others.",
    "neighbor rule": "`[formation] rule`.",
    "channel": "`[channel] model`.",
    "dynamics": "`[robots] dynamics`.",
    "metric": "`[[metric]] use`. The numbers are under `metrics` in the [summary](summary.md).",
}
"""Kind -> its place in a scenario."""

PURPOSES = {
    "disk": "Every peer that was heard within the timeout.",
    "two_nearest": "The two nearest of these peers, as in the paper's footnote 2.",
    "relative_neighborhood": "Each peer, unless a third robot is nearer to both than they are to each other.",
    "tolerant_relative_neighborhood": "The same, but a third robot must be nearer to both by `link_tolerance`.",
    "paper": "The sum of the separation errors of a robot's links, as in the paper.",
    "goals": "A goal of its own for each robot.",
    "alpha_lattice": "Flocking to a lattice of equal spacings (Olfati-Saber 2006).",
    "connectivity": "A tension that grows without bound as a link gets as long as the reach (Ji & Egerstedt 2007).",
    "gradient": "The gradient of the quality of the links (Heng Li et al. 2015).",
    "voronoi": "The centroid of the robot's Voronoi cell (Cortes et al. 2004).",
    "marks_and_plans": "Straight to the slots of the configuration, by a plan that all robots make alike.",
    "oracle": "(18) with the index of the channel's formula.",
    "sampled": "(18) with samples of J: S(r) for a decoded beacon, 0 for a lost one.",
    "measured, network": "The index by counted beacons; robots mix their counts (`pooling`).",
    "measured, none": "The index by counted beacons; each link learns alone.",
    "fixed_separation": "A constant separation: nothing is sought.",
    "krstic_wang": "Extremum seeking of each link by itself (Krstic & Wang 2000).",
    "rayleigh": "The probability of (3).",
    "logistic": "1 / (1 + exp((r - midpoint) / width)).",
    "perfect": "Each beacon in range decodes.",
    "table": "Straight lines between the `rows`.",
    "trace": "The values of a file, by time, sender and receiver.",
    "unicycle": "A body that follows its command exactly.",
}
"""Name -> purpose, for all but metrics; that of a metric is the docstring of its class."""

IN_SCENARIO = "the fields of `[{0}]`: see [scenario](scenario.md#{0})"
TABLES = {"seeking law": "seeking", "formation law": "formation", "neighbor rule": "formation", "channel": "channel"}
"""Kinds of which some extensions have the fields of a scenario's table as parameters."""

UNIT = re.compile(r" ?\[([^\];]+)[^\]]*\]")


def page() -> list[str]:
    """The lines of the page, without its title."""
    lines = []
    for kind in kinds.KINDS:
        if kind.built_in:
            lines += [f"## {kind.name.capitalize()}", "", f"Place in a scenario: {CHOSEN[kind.name]}", ""]
            lines += _of_kind(kind)
    return lines


def _of_kind(kind: Kind) -> list[str]:
    """The table of the names, and one row per parameter."""
    names, parameters = [], []
    for name in kind.built_in:
        loaded = registry.load(kind, name)
        told = " Told the channel." if name in kind.model_based else ""
        row = [_shown(name), _purpose(kind, name, loaded) + told]
        table_of: type[Table] = loaded.Parameters
        if kind is kinds.METRIC:
            row.append(", ".join(map(code, _numbers(name))))
        names.append([*row, _parameters(kind, table_of)])
        if _has_own(table_of):
            parameters += [[code(name), *_field(table_of, field)] for field in table_of.model_fields]
    heads = ["name", "purpose", *(["numbers"] if kind is kinds.METRIC else []), "parameters"]
    return [*table(heads, names), *(table(["of", *HEADS], parameters) if parameters else [])]


HEADS = ["parameter", "unit", "default", "meaning"]


def _shown(name: str) -> str:
    """The name as a scenario has it: `measured` with its pooling."""
    index, _, pooling = name.partition(", ")
    return f'{code(index)}, `pooling = "{pooling}"`' if pooling else code(name)


def _purpose(kind: Kind, name: str, loaded: Any) -> str:
    if kind is not kinds.METRIC:
        return prose(PURPOSES[name])
    return prose(f"{loaded.__doc__} {loaded.result.__doc__ or ''}".partition("\n\n")[0])


def _numbers(metric: str) -> list[str]:
    """The names of the numbers of a metric."""
    context = WorldContext(0.02, 2, ObjectiveConfig(), SeededDraws(0))
    return list(registry.create(kinds.METRIC, metric, context).result())


def _parameters(kind: Kind, parameters: type[Table]) -> str:
    if parameters is NoParameters:
        return "none"
    own = ", ".join(map(code, parameters.model_fields))
    return own if _has_own(parameters) else IN_SCENARIO.format(TABLES[kind.name])


def _has_own(parameters: type[Table]) -> bool:
    """True for parameters that are not the fields of a table of a scenario."""
    return parameters is not NoParameters and not parameters.__name__.endswith("Config")


def _field(parameters: type[Table], name: str) -> list[str]:
    """Name, unit, default and meaning of a parameter; the unit is the first text in brackets of its docstring."""
    text = attribute_docstrings(parameters)[name]
    unit = UNIT.search(text)
    field = parameters.model_fields[name]
    default = "required" if field.is_required() else "" if field.default is None else code(_number(field.default))
    return [code(name), unit[1] if unit else "", default, prose(UNIT.sub("", text, count=1))]


def _number(value: Any) -> str:
    """A default as a scenario has it.

    >>> _number((50.0, 90.0)), _number(0.1), _number(0.3141592653589793)
    ('[50.0, 90.0]', '0.1', '0.314159')
    """
    if isinstance(value, tuple):
        return f"[{', '.join(map(_number, value))}]"
    return f"{value:.6g}" if isinstance(value, float) and len(repr(value)) > 8 else repr(value)
