"""Extensions by name: what is found where, and one line for what is not."""

import sys
from pathlib import Path

import numpy as np
import pytest

from agents.laws.neighbor_rules import TwoNearest
from fes.errors import FesError
from fes.extension import registry
from fes.extension.kinds import FORMATION, RULE, Kind
from fes.model.table import Use
from tests.support import laws

SOURCE = '''
"""Toys of somebody else."""
from fes.extension import NoParameters, Table


class Ball:
    Parameters = NoParameters

    def __init__(self, parameters, context):
        self.context = context


class Top:
    class Parameters(Table):
        turns: float = 3.0
        color: str

    def __init__(self, parameters, context):
        self.parameters = parameters


class Shut:
    Parameters = NoParameters

    def __init__(self, parameters, context):
        raise RuntimeError("the box\\nis shut")


class Informed(Ball):
    knows_channel = True


class Loose:
    Parameters = dict
'''


def toys(group: str = "fes.tests_without_toys", **built_in: str) -> Kind:
    """A kind of extension that only this test knows."""
    return Kind("toy", group, built_in)


def installed(searched: Path, group: str, **classes: str) -> None:
    """Installs a distribution with entry points, as pip lays it out."""
    listed = "\n".join(f"{name} = {path}" for name, path in classes.items())
    metadata = searched / f"{group.replace('.', '_')}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {group}\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[{group}]\n{listed}\n")


def refusal(kind: Kind, choice: str | Use, context: object = None) -> str:
    """The line that rejects a choice."""
    with pytest.raises(FesError) as caught:
        registry.create(kind, choice, context)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_built_in_extension_is_found_by_its_name() -> None:
    assert registry.load(RULE, "two_nearest") is TwoNearest
    assert isinstance(registry.create(RULE, "two_nearest", laws.context(np.arange(3))), TwoNearest)


@pytest.mark.parametrize(
    ("kind", "name", "message"),
    [
        (RULE, "two_nearset", "there is no neighbor rule 'two_nearset'; did you mean 'two_nearest'?"),
        (FORMATION, "papers", "there is no formation law 'papers'; did you mean 'paper'?"),
        (
            RULE,
            "qqq",
            "there is no neighbor rule 'qqq'; known are disk, two_nearest, relative_neighborhood, "
            "tolerant_relative_neighborhood, and `module:Class`",
        ),
        (toys(), "ball", "there is no toy 'ball'; known are none, and `module:Class`"),
    ],
)
def test_an_unknown_name_is_rejected_with_the_nearest_one_or_all(kind: Kind, name: str, message: str) -> None:
    assert refusal(kind, name) == message


def test_a_long_name_is_cut_in_the_message() -> None:
    assert refusal(toys(), "x" * 200).startswith(f"there is no toy '{'x' * 60}'; ")


def test_a_class_is_not_imported_unless_its_module_was_allowed(searched: Path) -> None:
    (searched / "toys_of_a_stranger.py").write_text("raise SystemExit('imported')")
    message = (
        "toy 'toys_of_a_stranger:Ball': this process was not told to use module 'toys_of_a_stranger' "
        "(--use toys_of_a_stranger)"
    )
    assert refusal(toys(), "toys_of_a_stranger:Ball") == message
    assert "toys_of_a_stranger" not in sys.modules
    # a module that is imported already for another reason is not allowed by that
    assert refusal(RULE, "json:JSONDecoder").startswith("neighbor rule 'json:JSONDecoder': this process was not told")


def test_an_allowed_module_is_found_by_name_or_by_the_path_of_its_file(searched: Path) -> None:
    (searched / "toys_by_name.py").write_text(SOURCE)
    assert registry.use("toys_by_name") == "toys_by_name"
    assert registry.load(toys(), "toys_by_name:Ball").__name__ == "Ball"
    elsewhere = searched / "else where"
    elsewhere.mkdir()
    (elsewhere / "toys_by_path.py").write_text(SOURCE)
    assert registry.use(str(elsewhere / "toys_by_path.py")) == "toys_by_path"
    assert registry.load(toys(), "toys_by_path:Top.Parameters").__name__ == "Parameters"
    assert registry.used()[-2:] == ("toys_by_name", str(elsewhere / "toys_by_path.py"))
    assert registry.is_usable("toys_by_path")
    assert not registry.is_usable("toys_by_nobody")


@pytest.mark.parametrize(
    ("source", "error"),
    [
        ("import nothing_of_this_name", "ModuleNotFoundError: No module named 'nothing_of_this_name'"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("raise ValueError('two\\nlines')", "ValueError: two lines"),
        ("def", "SyntaxError: "),
    ],
)
def test_a_module_that_fails_is_rejected_in_one_line(searched: Path, source: str, error: str) -> None:
    (searched / "toys_that_fail.py").write_text(source)
    with pytest.raises(FesError) as caught:
        registry.use("toys_that_fail")
    assert str(caught.value).startswith(f"--use toys_that_fail: {error}")
    assert "\n" not in str(caught.value)
    assert refusal(toys(), "toys_that_fail:Ball").endswith("(--use toys_that_fail)")


def test_a_class_that_is_not_there_is_rejected_with_the_nearest_one(searched: Path) -> None:
    (searched / "toys_without_one.py").write_text(SOURCE)
    registry.use("toys_without_one")
    there = "toy 'toys_without_one:{0}': module 'toys_without_one' has no class '{0}'"
    assert refusal(toys(), "toys_without_one:Bal") == there.format("Bal") + "; did you mean 'Ball'?"
    assert refusal(toys(), "toys_without_one:Qqq") == there.format("Qqq")
    assert refusal(toys(), "toys_without_one:") == there.format("")
    assert refusal(toys(), "toys_without_one:Ball.inner") == there.format("Ball.inner")


def test_an_installed_extension_is_found_by_its_entry_point(searched: Path) -> None:
    (searched / "toys_installed.py").write_text(SOURCE)
    kind = toys("fes.tests_toys", own="agents.laws.neighbor_rules:Disk")
    classes = {"ball": "toys_installed:Ball", "lost": "toys_installed:Lost", "absent": "toys_absent:Ball"}
    installed(searched, kind.group, **classes)
    assert "toys_installed" not in sys.modules
    created = registry.create(kind, "ball", "the context")
    assert (type(created).__module__, type(created).__name__, created.context) == (
        "toys_installed",
        "Ball",
        "the context",
    )
    assert registry.is_usable("toys_installed")
    assert refusal(kind, "lost").startswith("toy 'lost': AttributeError: ")
    assert refusal(kind, "absent") == "toy 'absent': ModuleNotFoundError: No module named 'toys_absent'"
    assert refusal(kind, "bal") == "there is no toy 'bal'; did you mean 'ball'?"
    assert refusal(kind, "qqq") == "there is no toy 'qqq'; known are own, ball, lost, absent, and `module:Class`"


def test_a_built_in_name_is_never_that_of_an_installed_extension(searched: Path) -> None:
    kind = toys("fes.tests_shadows", own="agents.laws.neighbor_rules:TwoNearest")
    installed(searched, kind.group, own="toys_shadow:Ball")
    assert registry.load(kind, "own") is TwoNearest


def test_parameters_are_checked_by_the_class(searched: Path) -> None:
    (searched / "toys_with_parameters.py").write_text(SOURCE)
    registry.use("toys_with_parameters")
    name = "toys_with_parameters:Top"

    def choice(**parameters: object) -> Use:
        return Use.model_validate({"use": name, **parameters})

    made = registry.create(toys(), choice(color="red", turns=5.0), None)
    assert (made.parameters.color, made.parameters.turns) == ("red", 5.0)
    assert registry.create(toys(), choice(color="red"), None).parameters.turns == 3.0
    where = f"toy '{name}': "
    assert refusal(toys(), choice(colour="red")) == f"{where}unknown parameter 'colour'; did you mean 'color'?"
    assert refusal(toys(), choice(color="red", qqq=1)) == f"{where}unknown parameter 'qqq'; it has turns, color"
    assert refusal(toys(), choice(color=3)) == f"{where}color: must be a valid string"
    assert refusal(toys(), name) == f"{where}color: is required"


def test_an_extension_without_parameters_takes_none_and_one_without_a_table_is_rejected(searched: Path) -> None:
    (searched / "toys_without_parameters.py").write_text(SOURCE)
    registry.use("toys_without_parameters")
    ball, loose = "toys_without_parameters:Ball", "toys_without_parameters:Loose"
    assert refusal(toys(), Use.model_validate({"use": ball, "size": 1})) == (
        f"toy '{ball}': unknown parameter 'size'; it has none"
    )
    assert refusal(toys(), loose) == f"toy '{loose}': its `Parameters` is not a subclass of `fes.extension.Table`"


def test_a_constructor_that_fails_is_one_line(searched: Path) -> None:
    (searched / "toys_that_are_shut.py").write_text(SOURCE)
    registry.use("toys_that_are_shut")
    message = refusal(toys(), "toys_that_are_shut:Shut")
    assert message.startswith("toy 'toys_that_are_shut:Shut': ")
    assert message.endswith("RuntimeError: the box is shut")


def test_only_a_law_that_declares_it_is_told_the_channel(searched: Path) -> None:
    (searched / "toys_of_robots.py").write_text(SOURCE)
    registry.use("toys_of_robots")
    assert not registry.is_told(toys(), "toys_of_robots:Ball")
    assert registry.is_told(toys(), "toys_of_robots:Informed")


def test_a_check_needs_the_extension_but_loads_no_built_in_one() -> None:
    missing = toys(own="a_module_that_is_not_there:Toy")
    registry.check(missing, "own")
    with pytest.raises(FesError, match=r"^there is no toy 'other'; "):
        registry.check(missing, "other")
