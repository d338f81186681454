"""Leases, promises and refusals of robots, in the course of time."""

from fes.protocol.messages import Join
from world.execution.hosting import LEASE, RESUME_TIMEOUT, Admission, Hosting, Membership

NOW = 1000.0
TAKEN = "robot 0 is hosted by another agent already"
WELCOME = ""


def refusals(hosting: Hosting, now: float, *agents: int) -> list[str]:
    """The answers to agents that ask for robot 0, one after the other."""
    return [hosting.join(Join((0,), agent), now).refusal for agent in agents]


def test_a_leased_robot_is_free_again_if_its_agent_does_not_join() -> None:
    hosting = Hosting(2, Membership(), NOW)
    assert [hosting.lease(NOW) for _ in range(3)] == [0, 1, None]
    assert hosting.lease(NOW + LEASE - 0.1) is None
    assert [hosting.lease(NOW + LEASE) for _ in range(3)] == [0, 1, None]


def test_a_promised_robot_is_free_again_if_its_agent_shows_no_token() -> None:
    hosting = Hosting(2, Membership(), NOW)
    assert refusals(hosting, NOW, 7, 8, 7) == [WELCOME, TAKEN, WELCOME]
    assert refusals(hosting, NOW + LEASE - 0.1, 8) == [TAKEN]
    assert refusals(hosting, NOW + LEASE, 8, 7) == [WELCOME, TAKEN]
    assert hosting.lease(NOW + LEASE) == 1  # robot 0 is promised


def test_an_agent_that_asks_again_extends_its_promise() -> None:
    hosting = Hosting(1, Membership(), NOW)
    assert refusals(hosting, NOW, 7) == [WELCOME]
    assert refusals(hosting, NOW + LEASE - 1.0, 7) == [WELCOME]
    assert refusals(hosting, NOW + LEASE, 8) == [TAKEN]


def test_a_resumed_world_leases_no_robot_whose_agent_may_still_rejoin() -> None:
    hosting = Hosting(3, Membership({robot: Join((robot,), 7) for robot in (0, 1)}), NOW)
    assert [hosting.lease(NOW) for _ in range(2)] == [2, None]
    assert hosting.lease(NOW + RESUME_TIMEOUT - 0.1) == 2  # its lease has ended
    assert [hosting.lease(NOW + RESUME_TIMEOUT) for _ in range(3)] == [0, 1, None]


def test_a_robot_that_does_not_exist_and_one_of_an_earlier_world_are_refused() -> None:
    hosting = Hosting(2, Membership(), NOW)
    assert hosting.join(Join((1, 2), 7), NOW).refusal == "robot 2 does not exist: this run has robots 0 to 1"
    hosting.token(0, alive=True)
    assert hosting.join(Join((0, 1), 7), NOW).refusal == "robot 0 is hosted by an agent of an earlier world"
    assert hosting.hosts == {}


def test_a_robot_at_fault_is_refused_to_its_agent_and_free_for_another() -> None:
    hosting = Hosting(1, Membership(), NOW)
    assert refusals(hosting, NOW, 7) == [WELCOME]
    hosting.token(0, alive=True)
    hosting.exclude({0: "excluded at tick 3: it sent no beacon"})
    asked = hosting.join(Join((0,), 7), NOW)
    assert asked == Admission("robot 0 is excluded at tick 3: it sent no beacon", is_known=True)
    assert hosting.able.tolist() == [False]
    hosting.token(0, alive=False)
    assert refusals(hosting, NOW, 8) == [WELCOME]
    hosting.token(0, alive=True)
    assert hosting.able.tolist() == [True]


def test_a_judged_join_has_no_effect() -> None:
    hosting = Hosting(1, Membership(), NOW)
    assert hosting.judge(Join((0,), 7), NOW) == Admission(WELCOME, is_known=False)
    assert hosting.hosts == {}
    assert refusals(hosting, NOW, 8) == [WELCOME]


def test_a_robot_whose_partner_has_another_agent_is_hosted_only_while_both_are_alive() -> None:
    """Its agent reconnects and declares both tokens, though another agent has taken its second robot."""
    hosting = Hosting(2, Membership(), NOW)
    for join in (Join((0, 1), 7), Join((1,), 8)):
        assert hosting.join(join, NOW if join.agent == 7 else NOW + LEASE).refusal == WELCOME
    assert (hosting.group(0), hosting.group(1)) == ((0, 1), (1,))
    hosting.token(0, alive=True)
    assert hosting.hosted.tolist() == [False, False]
    hosting.token(1, alive=True)
    assert hosting.hosted.tolist() == [True, True]
    hosting.token(0, alive=False)
    assert hosting.hosted.tolist() == [False, True]
    hosting.token(0, alive=True)
    hosting.token(1, alive=False)
    assert hosting.hosted.tolist() == [False, False]
