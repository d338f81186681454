"""The model of differential drives on one floor, as MJCF.

Each robot has two driven wheels, two casters without friction, and a round body that meets the bodies of others. In
MuJoCo the friction of a contact is the larger one of its two geometries. So the casters have a higher priority than
the floor: else they would brake.
"""

import math
from xml.sax.saxutils import quoteattr

from fes.arrays.types import Floats
from world.config.hardware.tabletop import TabletopConfig

WHEEL_SHARE = 0.1
"""Share of a robot's mass that each wheel has [1]."""

ROTOR_SHARE = 0.25
"""Inertia of a motor's rotor, as a share of the robot's mass at the wheel's radius [1]. Without one the speed
overshoots: the physics step is longer than the time in which a bare wheel spins up."""

SERVO = 0.2
"""Torque of a motor per error of its speed, as a share of its top torque [s/rad]."""

FLOOR, BODIES = 1, 2
"""Bits of the kinds of contacts: with the floor, and between bodies."""


def mjcf(start: Floats, config: TabletopConfig) -> str:
    """The model of robots that start at `start` [n, 3] [m, m, rad; table frame]; joints and motors in their order."""
    robots = "".join(_robot(robot, pose, config) for robot, pose in enumerate(start.tolist()))
    motors = "".join(_motor(f"{side}{robot}", config) for robot in range(len(start)) for side in ("left", "right"))
    step = _attributes(timestep=config.physics_step, integrator="implicitfast", cone="elliptic")
    return (
        f'<mujoco model="tabletop"><compiler angle="radian"/>'
        f'<option {step}><flag autoreset="disable"/></option>'
        f'<worldbody><geom name="floor" type="plane" size="0 0 1" friction="1 0.001 0.0001" '
        f'contype="{FLOOR}" conaffinity="{FLOOR}"/>{robots}</worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


def _robot(robot: int, start: list[float], config: TabletopConfig) -> str:
    x, y, heading = start
    radius, half_track, size = config.wheel_radius, 0.5 * config.track, config.body_radius
    caster = 0.5 * radius
    reach = size - caster
    half_height = 0.75 * radius
    wheel_mass = WHEEL_SHARE * config.mass
    rotor = ROTOR_SHARE * config.mass * radius**2
    body = _attributes(
        type="cylinder",
        size=(size, half_height),
        pos=(0.0, 0.0, 1.25 * radius),
        mass=config.mass - 2.0 * wheel_mass,
        friction=(0.3, 0.001, 0.0001),
        contype=BODIES,
        conaffinity=BODIES,
    )
    sphere = {"type": "sphere", "size": caster, "mass": 0.0, "friction": (0.0, 0.0, 0.0), "condim": 1}
    casters = "".join(
        f"<geom {_attributes(**sphere, pos=(place, 0.0, caster), priority=1, contype=FLOOR, conaffinity=0)}/>"
        for place in (reach, -reach)
    )
    wheels = "".join(
        f"<body {_attributes(pos=(0.0, side, radius))}>"
        f"<joint {_attributes(name=f'{name}{robot}', type='hinge', axis=(0.0, 1.0, 0.0), armature=rotor)}/>"
        f"<geom {_wheel(radius, wheel_mass)}/></body>"
        for name, side in (("left", half_track), ("right", -half_track))
    )
    pose = _attributes(pos=(x, y, 0.0), quat=(math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading)))
    name = quoteattr(f"robot{robot}")
    return f'<body name={name} {pose}><freejoint name="free{robot}"/><geom {body}/>{casters}{wheels}</body>'


def _wheel(radius: float, mass: float) -> str:
    return _attributes(
        type="cylinder",
        size=(radius, 0.1 * radius),
        quat=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0),
        mass=mass,
        friction=(1.0, 0.001, 0.0001),
        contype=FLOOR,
        conaffinity=0,
    )


def _motor(joint: str, config: TabletopConfig) -> str:
    """A servo of speed whose command passes a low-pass filter, and whose torque is limited."""
    gain = SERVO * config.motor_torque
    return "<general {}/>".format(
        _attributes(
            joint=joint,
            dyntype="filterexact",
            dynprm=config.motor_time_constant,
            gaintype="fixed",
            gainprm=gain,
            biastype="affine",
            biasprm=(0.0, 0.0, -gain),
            forcelimited="true",
            forcerange=(-config.motor_torque, config.motor_torque),
        )
    )


def _attributes(**values: object) -> str:
    return " ".join(f"{name}={quoteattr(_text(value))}" for name, value in values.items())


def _text(value: object) -> str:
    return " ".join(map(_text, value)) if isinstance(value, tuple) else str(value)
