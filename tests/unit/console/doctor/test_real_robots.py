"""The finding of fes doctor on a run of real robots, which has no world."""

from console.doctor import network
from console.doctor.finding import Status
from fes.protocol import keys


def tokens(gates: list[int], agents: list[int]) -> list[str]:
    return [keys.gate_alive("main", robot) for robot in gates] + [keys.robot_alive("main", robot) for robot in agents]


def test_gates_and_agents_of_real_robots_are_named_and_no_world_is_missed() -> None:
    finding = network.alive("main", tokens([0, 1, 2], [0, 1, 2]), [], None, True)
    assert (finding.status, finding.seen) == (Status.OK, "real robots of run 'main': gates 0-2, agents 0-2")


def test_a_gate_without_an_agent_is_a_warning() -> None:
    finding = network.alive("main", tokens([0, 1, 2], [0]), [], None, True)
    assert (finding.status, finding.seen) == (Status.WARNING, "real robots of run 'main': gates 0-2, agents 0")


def test_agents_alone_still_miss_their_world() -> None:
    assert network.alive("main", tokens([], [0]), [], None, True).status is Status.FAILED
