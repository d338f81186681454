"""Keys: every function yields a key of the module's table, and a key tells whose it is."""

import re
import uuid

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.errors import FesError
from fes.protocol import keys
from fes.transport.session import LONGEST_NAMESPACE
from tests.support.role_keys import ROBOT, WORLD

TABLE = re.findall(r"^\| (fes/\S+)", keys.__doc__ or "", flags=re.MULTILINE)

runs = st.from_regex(r"[A-Za-z0-9_.-]{1,64}", fullmatch=True)
robots = st.integers(0, 2**31 - 1)


def test_each_function_yields_one_key_of_the_table_and_the_table_has_no_other() -> None:
    yielded = [world("<run>") for world in WORLD] + [robot("<run>", "<i>") for robot in ROBOT]
    yielded += [keys.welcome("<run>", "<ids>"), keys.held_beacon("<run>", "<i>", "<ids>")]
    assert sorted(yielded) == sorted(TABLE)
    assert len(set(TABLE)) == 19


@given(run=runs, robot=robots)
def test_each_key_of_a_robot_yields_its_id(run: str, robot: int) -> None:
    assert [keys.robot_of(key(run, robot)) for key in ROBOT] == [robot] * len(ROBOT)


@given(run=runs)
def test_the_worlds_keys_and_patterns_belong_to_no_robot(run: str) -> None:
    assert [keys.robot_of(key(run)) for key in WORLD] == [None] * len(WORLD)
    assert keys.robot_of(keys.welcome(run, "3")) is None
    assert keys.robot_of(keys.held_beacon(run, 3, "4")) is None
    assert [keys.robot_of(key(run, "*")) for key in ROBOT] == [None] * len(ROBOT)


def test_the_longest_key_is_far_below_zenohs_limit() -> None:
    """Zenoh's client ends its process at a key of 65,535 bytes; a namespace of its own may come before ours."""
    run, robot = keys.check_run("r" * 64), keys.MAX_ROBOTS - 1
    longest = [keys.claim(run, uuid.uuid4().hex), keys.welcome(run, keys.span([robot - 1, robot]))]
    longest += [world(run) for world in WORLD] + [key(run, robot) for key in ROBOT]
    assert max(len(key.encode()) for key in longest) < 200
    assert 200 + LONGEST_NAMESPACE * 4 < 65_535 / 10


@given(key=st.text() | st.from_regex(r"fes/main/robot/[^/]{0,12}/[a-z]{0,9}", fullmatch=True))
def test_any_key_yields_a_robot_or_none(key: str) -> None:
    robot = keys.robot_of(key)
    assert robot is None or (robot >= 0 and key.startswith("fes/") and "/robot/" in key)


@pytest.mark.parametrize(
    "key",
    [
        "",
        "fes/main/robot/3",
        "fes/main/robot//beacon",
        "fes/main/robot/-3/beacon",
        "fes/main/robot/3/beacon/",
        "fes/main/robot/3/beacon\n",
        "/fes/main/robot/3/beacon",
        "fes/main/robots/3/beacon",
        "fes/a/b/robot/3/beacon",
        "fes/main/robot/three/beacon",
        "fes/main/robot/**/beacon",
        "fes/main/robot/12345678901/beacon",
    ],
)
def test_a_key_of_another_form_belongs_to_no_robot(key: str) -> None:
    assert keys.robot_of(key) is None


@pytest.mark.parametrize("digits", ["03", "0000000003", "٣"])
def test_a_robot_has_one_key_of_each_kind_only(digits: str) -> None:
    assert keys.robot_of(f"fes/main/robot/{digits}/alive") is None


@pytest.mark.parametrize("run", ["main", "a", "A-b_c.9", "x" * 64, "-", "."])
def test_a_run_may_be_named_with_letters_digits_and_three_signs(run: str) -> None:
    assert keys.check_run(run) == run


@pytest.mark.parametrize("run", ["", "x" * 65, "a/b", "a b", "*", "a*", "**", "$*", "a?", "a#", "@a", "ä", "a\n"])
def test_a_name_that_would_be_a_pattern_or_another_key_is_rejected_with_the_name(run: str) -> None:
    with pytest.raises(FesError, match="1 to 64 letters") as caught:
        keys.check_run(run)
    assert str(caught.value).endswith(f"got '{run}'")
