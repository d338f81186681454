"""Ten robots without a world: each steps a crew of its own at times of its own, and senses by what its radio hears.

Bodies follow the unicycle (5) exactly. A beacon decodes with the probability of (3) at the true separation of that
moment, and arrives after a delay. No robot is told anything else.
"""

import heapq
import math
from dataclasses import dataclass, field

import numpy as np

from agents.runtime.hosted_crew import HostedCrew
from fes.arrays.types import Floats
from fes.model import kinematics
from fes.protocol.messages import Beacon, Command, Welcome, decode_beacon, decode_command
from fes.protocol.sealed import Sealed
from field.senses.own_poses import Pose
from field.senses.senses import Senses
from tests.support.measured_links import rayleigh
from world.config.scenario import Scenario, agent_config

OPTIMUM = 68.11376
"""The separation that every link should have [m]."""

SETTLED = 10.0
"""Time from which the robots only follow the dither [s]: the team is within 1 m of the optimum before."""

SAMPLE = 10
"""From SETTLED on, one of so many ticks is a sample."""

REACH = 150.0
"""Range of the radio [m]."""


@dataclass
class Team:
    """The state of a run."""

    scenario: Scenario
    seed: int
    clock_error: float = 0.03
    """Largest difference of a clock from the true time [s]."""
    drift: float = 5e-5
    jitter: float = 0.01
    """Largest delay of a beacon [s]."""
    times: list[float] = field(default_factory=list)
    """Time of each own step of robot 0 [s]."""
    errors: list[float] = field(default_factory=list)
    """Mean of all estimates less the optimum, at these times [m]."""
    by_tick: list[float] = field(default_factory=list)
    """Error of separations between a beacon's pose and the own pose of the tick before, which a crew uses [m]: a
    sample."""
    by_reception: list[float] = field(default_factory=list)
    """The same with the own pose at its reception [m]."""
    delivered: int = 0
    """Beacons that the channel let pass."""
    heard: int = 0
    """Beacons that the radios heard."""
    strict: int = 0
    """Those of them that would count if a beacon had to have the number of the robot's own last tick."""

    def __post_init__(self) -> None:
        run, rng = self.scenario.run, np.random.default_rng(self.seed)
        self.dt, self.poses = run.dt, np.array(self.scenario.robots.poses, dtype=np.float64)
        n = len(self.poses)
        self._rng, self._moved, self._twists = rng, np.zeros(n), np.zeros((n, 2))
        self._clock = rng.uniform(-self.clock_error, self.clock_error, n)
        self._rate = 1.0 + rng.uniform(-self.drift, self.drift, n)
        config = agent_config(self.scenario)
        self._crews = [HostedCrew(Welcome((robot,), config)) for robot in range(n)]
        self.senses = [Senses(robot, round(2.0 / self.dt)) for robot in range(n)]
        self._own: list[Pose] = [(0.0, 0.0, 0.0)] * n
        self._true: dict[tuple[int, Pose], Floats] = {}
        self._on_air: list[list[tuple[float, Sealed, Beacon]]] = [[] for _ in range(n)]
        self._estimates: list[Command | None] = [None] * n

    def run(self, duration: float) -> None:
        """Run for `duration` [s]."""
        steps = [(self._due(robot, 2), robot, 2) for robot in range(len(self.poses))]
        heapq.heapify(steps)
        while steps[0][0] < duration:
            now, robot, tick = heapq.heappop(steps)
            self._step(now, robot, tick)
            heapq.heappush(steps, (self._due(robot, tick + 1), robot, tick + 1))

    def bias(self, since: float) -> float:
        """Mean error of the estimates from the time `since` [s] on [m]."""
        return float(np.mean([error for time, error in zip(self.times, self.errors, strict=True) if time >= since]))

    def _due(self, robot: int, tick: int) -> float:
        """True time of a robot's step [s]."""
        return float(tick * self.dt * self._rate[robot] + self._clock[robot])

    def _step(self, now: float, robot: int, tick: int) -> None:
        """One robot's step: hear what has arrived, sense, move on, send."""
        self._listen(now, robot, tick)
        self._move(now)
        pose = tuple(self.poses[robot].tolist())
        observation, beacons = self.senses[robot].step(tick, pose, tick, 0)
        if tick % SAMPLE == 0 and now >= SETTLED:
            self._compare(robot, tick, beacons)
        crew = self._crews[robot]
        [(_, payload, command)] = crew.answer(crew.observe([observation]), beacons)
        answer = self._estimates[robot] = decode_command(command)
        self._twists[robot] = answer.twist
        self._send(now, robot, Sealed(robot, 1, tick, payload))
        if robot == 0:
            told = [each.estimates for each in self._estimates if each is not None]
            mean = np.concatenate(told).mean() if sum(map(len, told)) else np.nan
            self.times.append(now)
            self.errors.append(float(mean - OPTIMUM))

    def _compare(self, robot: int, tick: int, beacons: list[Beacon]) -> None:
        """Compare separations by two own poses with the true one when the beacon was sent."""
        pairs = zip(beacons, self.senses[robot].poses_at_reception(), strict=True)
        for beacon, at_reception in pairs:
            true = self._true[beacon.robot, beacon.pose][robot]
            for own, errors in ((self._own[robot], self.by_tick), (at_reception, self.by_reception)):
                errors.append(math.hypot(beacon.pose[0] - own[0], beacon.pose[1] - own[1]) - true)

    def _listen(self, now: float, robot: int, tick: int) -> None:
        """Hand the senses what has arrived until now."""
        queue = self._on_air[robot]
        while queue and queue[0][0] <= now:
            arrived, sealed, beacon = heapq.heappop(queue)
            own = (arrived - self._clock[robot]) / (self.dt * self._rate[robot])
            self.senses[robot].hear(sealed, beacon, float(own))
            self.heard += 1
            self.strict += beacon.tick == tick - 1

    def _send(self, now: float, robot: int, sealed: Sealed) -> None:
        """Put a beacon on the air: each peer decodes it or not, by its separation at this moment."""
        away = self.poses[:, :2] - self.poses[robot, :2]
        separation: Floats = np.hypot(away[:, 0], away[:, 1])
        decoded = (self._rng.random(len(self.poses)) < rayleigh(separation)) & (separation < REACH)
        decoded[robot] = False
        beacon = decode_beacon(sealed.payload)
        self._true[robot, beacon.pose] = separation
        self._own[robot] = beacon.pose
        self.delivered += int(decoded.sum())
        for peer in np.flatnonzero(decoded).tolist():
            arrival = now + self.jitter * self._rng.random()
            heapq.heappush(self._on_air[peer], (arrival, sealed, beacon))

    def _move(self, now: float) -> None:
        """Bring all bodies to the present."""
        passed = (now - self._moved)[:, None]
        # a unit of time in which a body covers what it covers in the time that has passed
        self.poses, self._moved = (
            kinematics.move(self.poses, passed * self._twists, 1.0),
            np.full_like(self._moved, now),
        )
