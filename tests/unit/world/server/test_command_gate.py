"""Commands pass only from the agent that was accepted for their robot."""

from fes.protocol import keys
from fes.protocol.messages import Join
from world.server.command_gate import CommandGate

CREW, SUCCESSOR = Join((0, 1, 2), 7), Join((1,), 8)


def test_only_commands_with_the_number_of_the_accepted_agent_pass_and_others_are_counted() -> None:
    gate = CommandGate("r", {})
    gate.expect(CREW)
    assert gate.admits(keys.command("r", 1), CREW.mark)
    assert not gate.admits(keys.command("r", 1), SUCCESSOR.mark)
    assert not gate.admits(keys.command("r", 1), b"")
    assert not gate.admits(keys.command("r", 5), CREW.mark)
    assert gate.rejected == 3


def test_a_resumed_world_expects_the_last_agent_of_each_robot_and_not_that_of_an_older_join() -> None:
    gate = CommandGate("r", {0: CREW, 1: SUCCESSOR, 2: CREW})
    assert [gate.admits(keys.command("r", robot), CREW.mark) for robot in range(3)] == [True, False, True]
    assert gate.admits(keys.command("r", 1), SUCCESSOR.mark)
