"""The pure gate in tests: its events at chosen times, and a body that does what it commands."""

import math
from typing import Any

from fes.protocol.robot_control import GateStatus, Permit, Start
from fes.ros.messages import PoseMessage
from field.gate.rules import gate as rules
from field.gate.rules.settings import Limits, Settings, Timing
from field.gate.rules.state import Gate, Order

PERIOD = 0.02
FRAME = "map"
AHEAD = 5000.0
"""Reading of the operator's clock at time 0 of the gate's [s]."""
ROUNDING = 1e-9
"""Far above the rounding of sums and times of some seconds, far below any limit."""


def settings(**changes: Any) -> Settings:
    """Settings of robot 3 with changed fields; those of Limits and Timing are given by their own names."""
    limits = {name: changes.pop(name) for name in [*changes] if name in Limits.__dataclass_fields__}
    timing = {name: changes.pop(name) for name in [*changes] if name in Timing.__dataclass_fields__}
    parts = {"limits": Limits(**limits), "timing": Timing(**timing)}
    return Settings(robot=3, **{**parts, **changes})


class Rig:
    """A gate, its time, and a body that moves as it commands."""

    def __init__(self, chosen: Settings | None = None) -> None:
        self.settings = chosen or settings()
        self.gate = Gate(zero=10**18)
        self.now = 100.0
        self.sequence = 0
        self.permit_number = 0
        self.pose = [0.0, 0.0, 0.0]
        """x, y, heading [m of the body]."""
        self.stamp = 1_000_000_000
        self.slip = (1.0, 1.0)
        """Factors of the body's linear and angular velocity."""

    @property
    def status(self) -> GateStatus:
        return rules.status(self.gate, self.settings, self.now)

    def permit(self, operator: int = 1, number: int | None = None, delay: float = 0.0) -> None:
        """A Permit arrives `delay` [s] after it was sent."""
        self.permit_number += 1
        sent_at = round(1e9 * (self.now - delay + AHEAD))
        permit = Permit(operator, self.permit_number if number is None else number, sent_at)
        self.gate = rules.permitted(self.gate, self.settings, self.now, permit)

    def see(self, frame: str = FRAME, shift: float = 0.0, stamp: int | None = None) -> None:
        """A pose arrives from the body, moved by `shift` [m]."""
        self.stamp += 20_000_000
        x, y, heading = self.pose
        message = PoseMessage(self.stamp if stamp is None else stamp, frame, x + shift, y, heading)
        self.gate = rules.posed(self.gate, self.settings, self.now, message)

    def command(
        self, linear: float, angular: float = 0.0, age: float = 0.0, step: int = 1, heard: float = 0.0
    ) -> None:
        """A command arrives that was computed `age` [s] ago; its robot heard a peer `heard` [s] ago."""
        self.sequence += step
        order = Order(self.sequence, self.now - age, linear, angular, self.now - heard)
        self.gate = rules.commanded(self.gate, self.settings, self.now, order)

    def start(self, age: float = 0.0) -> str:
        """A start arrives `age` [s] after the state that it quotes."""
        start = Start(rules.clock(self.gate, self.now - age))
        self.gate, refusal = rules.started(self.gate, self.settings, self.now, start)
        return refusal

    def tick(self, dt: float = PERIOD, late: float = 0.0) -> None:
        """The body moves for `dt` [s], and the gate's loop has its turn."""
        linear, angular = self.gate.twist
        x, y, heading = self.pose
        turn = self.slip[1] * angular * dt
        travel, middle = self.slip[0] * linear * dt, heading + turn / 2
        self.pose = [x + travel * math.cos(middle), y + travel * math.sin(middle), heading + turn]
        self.now += dt
        self.gate = rules.updated(self.gate, self.settings, self.now, late)

    def run(self, seconds: float, linear: float = 0.0, angular: float = 0.0) -> None:
        """Everything works for some time: permits, poses and commands arrive."""
        for _ in range(round(seconds / PERIOD)):
            self.permit()
            self.see()
            self.command(linear, angular)
            self.tick()


def running(linear: float = 0.1, chosen: Settings | None = None) -> Rig:
    """A gate that has been started, whose body has reached a constant velocity."""
    rig = Rig(chosen)
    rig.permit()
    rig.see()
    refusal = rig.start()
    assert refusal == "", refusal
    rig.run(1.0, linear)
    return rig
