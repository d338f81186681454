"""One tick of a real robot, and the warm-up before its first one."""

import pytest

from fes.errors import FesError
from fes.model.config import AgentConfig
from fes.protocol import messages
from fes.protocol.sealed import Sealed
from field.runtime import stepper
from field.runtime.fixes import Fix
from field.runtime.stepper import Stepper
from field.senses.senses import Senses
from field.settings import robot_file

CONFIG = robot_file.parse({"schema": 1}, "robot.toml").agent_config


def beacons(config: AgentConfig, warm: bool) -> list[bytes]:
    """The beacons of three ticks, after a warm-up or without one."""
    if warm:
        stepper.warm_up(config, 3)
    own = Stepper(config, 3, Senses(3, 50))
    return [own.step(tick, Fix((1.0, 2.0, 0.5), tick), 10).beacon for tick in (10, 11, 12)]


def test_a_warm_up_changes_no_digit() -> None:
    assert beacons(CONFIG, warm=True) == beacons(CONFIG, warm=False)


def test_settings_that_no_crew_accepts_are_refused_before_the_robot_moves() -> None:
    broken = CONFIG.model_copy(update={"controller": "absent:Class"})
    with pytest.raises(FesError, match="absent"):
        stepper.warm_up(broken, 0)


def test_a_step_answers_for_the_tick_of_its_fix_with_what_was_heard_before() -> None:
    senses = Senses(0, 50)
    own, peer = Stepper(CONFIG, 0, senses), Stepper(CONFIG, 1, Senses(1, 50))
    steps = []
    for tick in range(1, 8):
        steps.append(own.step(tick, Fix((0.0, 0.0, 0.0), tick), 1))
        payload = peer.step(tick, Fix((60.0, 0.0, 0.0), tick), 1).beacon
        senses.hear(Sealed(1, 9, tick, payload), messages.decode_beacon(payload), tick + 0.5)
    assert steps[-1].observation.tick == 7
    assert [beacon.robot for beacon in steps[-1].heard] == [1]
    assert messages.decode_command(steps[-1].command).links.tolist() == [1]
