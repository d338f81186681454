"""Access control: generated from the table of keys, judged by Zenoh's own key expressions."""

from collections.abc import Sequence
from typing import Any, overload

import pytest
import zenoh

from fes.protocol import keys
from tests.support.role_keys import ROBOT, WORLD
from world.server import access

RUN = "r"
CONTROL: Any = access.control(RUN, 6, [range(4, 6), range(4, 9)])["access_control"]


def permitted(role: str, flow: str, message: str, key: str) -> bool:
    """True if a rule of the role includes the message, as Zenoh decides."""
    rules = {name for policy in CONTROL["policies"] if role in policy["subjects"] for name in policy["rules"]}
    return any(
        message in rule["messages"] and flow in rule["flows"] and zenoh.KeyExpr(pattern).includes(zenoh.KeyExpr(key))
        for rule in CONTROL["rules"]
        if rule["id"] in rules
        for pattern in rule["key_exprs"]
    )


def everything(message: str, flow: str, role: str) -> set[str]:
    """The keys of the table, for robots 2 to 4, on which a role may send or receive such a message."""
    table = [key(RUN) for key in WORLD] + [key(RUN, robot) for key in ROBOT for robot in (2, 3, 4)]
    table += [keys.held_beacon(RUN, robot, ids) for robot in (2, 3, 4) for ids in ("2", "3", "4", "4-5")]
    table += [keys.welcome(RUN, ids) for ids in ("2", "3", "4", "4-5")]
    return {key.removeprefix("fes/r/") for key in table if permitted(role, flow, message, key)}


BEACONS = {f"robot/{robot}/beacon" for robot in (2, 3, 4)}
TOKENS = {"world/alive", *(f"robot/{robot}/{kind}" for robot in (2, 3, 4) for kind in ("alive", "gate"))}
REPORTS = {"world/report", *(f"robot/{robot}/report" for robot in (2, 3, 4))}
STATUS = {f"robot/{robot}/status" for robot in (2, 3, 4)}
MOTION = {f"robot/{robot}/{verb}" for robot in (2, 3, 4) for verb in ("start", "stop")}
GATE_3 = {"robot/3/start", "robot/3/stop", "robot/3/status"}


def recalled(ids: str) -> set[str]:
    """The keys on which an agent recalls beacons that it missed."""
    return {f"world/beacon/{robot}/{ids}" for robot in (2, 3, 4)}


def test_a_robot_publishes_only_on_its_own_keys() -> None:
    assert everything("put", "ingress", "robot-3") == {"robot/3/beacon", "robot/3/command", "robot/3/report"}
    assert everything("liveliness_token", "ingress", "robot-3") == {"robot/3/alive", "robot/3/gate"}
    assert everything("query", "ingress", "robot-3") == {"world/welcome/3", *recalled("3")}
    for message in ("declare_queryable", "reply"):
        assert everything(message, "ingress", "robot-3") == {"robot/3/recall", *GATE_3}


def test_a_robot_receives_its_own_observation_beacons_permits_and_the_token_of_the_world() -> None:
    for flow, message in (("ingress", "declare_subscriber"), ("egress", "put")):
        assert everything(message, flow, "robot-3") == {"robot/3/observation", "team/permit", *BEACONS}
    assert everything("declare_liveliness_subscriber", "ingress", "robot-3") == {"world/alive"}
    assert everything("liveliness_token", "egress", "robot-3") == {"world/alive", "robot/3/gate"}
    assert everything("reply", "egress", "robot-3") == {"world/welcome/3", *recalled("3")}
    assert everything("query", "egress", "robot-3") == {"robot/3/recall", *GATE_3}


def test_a_gate_may_only_ask_whether_another_gate_of_its_own_robot_is_alive() -> None:
    assert everything("liveliness_query", "ingress", "robot-3") == {"robot/3/gate"}


def test_a_crew_has_the_rights_of_its_robots_and_asks_for_them_together() -> None:
    assert everything("put", "ingress", "robot-4-5") == {"robot/4/beacon", "robot/4/command", "robot/4/report"}
    assert everything("query", "ingress", "robot-4-5") == {"world/welcome/4-5", *recalled("4-5")}


@pytest.mark.parametrize("role", ["observer", "operator"])
def test_observers_and_operators_receive_reports_and_tokens_and_only_operators_publish_a_permit(role: str) -> None:
    for flow, message in (("ingress", "declare_subscriber"), ("egress", "put")):
        assert everything(message, flow, role) == REPORTS
    for flow, message in (("ingress", "declare_liveliness_subscriber"), ("egress", "liveliness_token")):
        assert everything(message, flow, role) == TOKENS
    assert everything("put", "ingress", role) == ({"team/permit"} if role == "operator" else set())
    assert everything("liveliness_token", "ingress", role) == set()


def test_observers_ask_gates_for_their_state_and_only_operators_start_and_stop_robots() -> None:
    assert everything("query", "ingress", "observer") == {"world/about", *STATUS}
    assert everything("query", "ingress", "operator") == {"world/about", "world/set", *STATUS, *MOTION}
    for role in ("observer", "operator"):
        assert everything("reply", "egress", role) == everything("query", "ingress", role)
        assert everything("reply", "ingress", role) == set()


def test_only_an_operator_may_request_a_change() -> None:
    asking = {role for role in SUBJECTS if "world/set" in everything("query", "ingress", role)}
    assert asking == {"operator"}


class Endless(Sequence[int]):
    """The crew of a foreign certificate, with too many robots to look at each."""

    def __len__(self) -> int:
        return 10**10

    @overload
    def __getitem__(self, index: int) -> int: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[int]: ...
    def __getitem__(self, index: int | slice) -> int | Sequence[int]:
        return range(10**10)[index]

    def __iter__(self) -> Any:
        raise AssertionError("all robots of a crew were looked at")


def test_a_crew_that_no_run_can_have_costs_nothing() -> None:
    assert access.control(RUN, 6, [range(4, 6), Endless()])["access_control"] == CONTROL


SUBJECTS = [name for subject in CONTROL["subjects"] for name in subject["cert_common_names"]]


def test_no_robot_may_delete_reply_or_use_a_pattern_and_every_other_message_is_denied() -> None:
    assert CONTROL["enabled"]
    assert CONTROL["default_permission"] == "deny"
    for role in SUBJECTS:
        assert everything("delete", "ingress", role) == set()
        for message in ("declare_queryable", "reply"):
            answers = ("/recall", "/start", "/stop", "/status")
            assert not {key for key in everything(message, "ingress", role) if not key.endswith(answers)}
        person = role in ("observer", "operator")
        assert permitted(role, "ingress", "liveliness_query", "fes/r/**") == person
        for message in ("put", "query", "liveliness_token"):
            assert not permitted(role, "ingress", message, "fes/r/**")
            assert not permitted(role, "ingress", message, "fes/r/robot/*/beacon")
        assert not permitted(role, "ingress", "declare_subscriber", "fes/r/robot/*/observation")
        assert not permitted(role, "ingress", "declare_subscriber", "fes/r/**")
        assert not permitted(role, "ingress", "put", "fes/other/robot/3/beacon")


def test_subjects_are_the_robots_of_the_run_crews_within_it_observers_and_operators() -> None:
    assert [*(f"robot-{robot}" for robot in range(6)), "robot-4-5", "observer", "operator"] == SUBJECTS
