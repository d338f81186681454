"""The kind of an extension follows from its methods."""

import pytest

from fes.extension import kinds, registry
from fes.extension.kinds import CHANNEL, CONTROLLER, DYNAMICS, FORMATION, KINDS, METRIC, RULE, SEEKING, Kind
from fes.model.table import Table
from tests.support import broken_laws, broken_worlds

SEEKING_METHODS = ("start", "forget", "relink", "desired", "measure", "publish", "seek")


def with_methods(*names: str) -> type:
    return type("Extension", (), {name: lambda self: None for name in names})


@pytest.mark.parametrize(
    ("loaded", "kind"),
    [
        (with_methods("step"), CONTROLLER),
        (with_methods(*SEEKING_METHODS), SEEKING),
        (with_methods("pair_probability"), CHANNEL),
        (broken_laws.Law, FORMATION),
        (broken_laws.Rule, RULE),
        (broken_laws.RuleWithMemory, RULE),
        (broken_worlds.Channel, CHANNEL),
        (broken_worlds.Bodies, DYNAMICS),
        (broken_worlds.Metric, METRIC),
    ],
)
def test_a_class_is_of_the_kind_whose_methods_it_has(loaded: type, kind: Kind) -> None:
    assert kinds.infer(loaded) == [kind]
    assert kind.missing(loaded) == ""


def test_a_class_with_a_state_and_without_forget_is_not_a_controller() -> None:
    assert kinds.infer(with_methods("start", "step")) == []
    assert kinds.nearest(with_methods("start", "step", "seek")) in (FORMATION, DYNAMICS)
    assert FORMATION.missing(with_methods("start", "step")) == "forget"


def test_a_class_with_the_methods_of_two_kinds_is_of_both() -> None:
    assert set(map(id, kinds.infer(broken_laws.Ambiguous))) == {id(FORMATION), id(DYNAMICS)}
    assert [kind.name for kind in kinds.infer(with_methods("add", "result", "probability"))] == ["channel", "metric"]


def test_every_class_can_be_called_but_only_a_rule_has_the_method_call() -> None:
    assert RULE.missing(broken_worlds.Metric) == "__call__"
    assert kinds.infer(object) == []
    assert kinds.nearest(object) is None


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_built_in_extensions_have_the_methods_of_their_kind(kind: Kind) -> None:
    for path in kind.built_in.values():
        module, _, name = path.partition(":")
        assert kind.missing(getattr(__import__(module, fromlist=[name]), name)) == "", path


def test_every_kind_has_a_group_of_entry_points_of_its_own() -> None:
    assert len({kind.group for kind in KINDS}) == len({kind.name for kind in KINDS}) == len(KINDS) == 7
    assert all(kind.group.startswith("fes.") for kind in KINDS)


def test_the_table_of_parameters_of_a_built_in_seeking_law_is_that_of_its_settings() -> None:
    for name in ("oracle", "sampled", "measured, network", "measured, none"):
        table = registry.load(SEEKING, name).Parameters
        assert issubclass(table, Table)
        assert table.model_fields["index"].annotation.__args__ == (name.partition(",")[0],)
