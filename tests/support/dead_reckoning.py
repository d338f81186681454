"""Dead reckoning of one robot in plain numbers, a second implementation."""

import math


class OneRobot:
    """The filter of one robot in plain numbers, written from its description alone."""

    def __init__(self, noise: float, heading: float, lag: float, dt: float) -> None:
        self._dt = dt
        self.told, self.lag = (noise**2, heading**2), lag
        self.pose: list[float] = []
        self.past: dict[int, list[float]] = {}
        self.rejected, self.used = 0, -1
        self.body = self.twist = (0.0, 0.0)

    def step(self, tick: int, fix: tuple[float, float, float], fixed: int) -> None:
        if not self.pose:
            self.pose, self.variance, self.used = list(fix), list(self.told), fixed
            self.past = {old: list(fix) for old in range(tick - 60, tick + 1)}
            return
        self._predict(tick)
        if fixed <= self.used or tick - fixed > 50:
            return
        self.used, then = fixed, self.past[fixed]
        change = [fix[0] - then[0], fix[1] - then[1], math.remainder(fix[2] - then[2], 2.0 * math.pi)]
        if change[0] ** 2 + change[1] ** 2 > 25.0 * (self.variance[0] + self.told[0]):
            self.rejected += 1
            if self.rejected < 5:
                return
            gains, self.body = [1.0, 1.0], (0.0, 0.0)
        else:
            gains = [p / (p + s) for p, s in zip(self.variance, self.told, strict=True)]
        self.rejected = 0
        self.variance = [gain * s for gain, s in zip(gains, self.told, strict=True)]
        for pose in self.past.values():
            for axis, gain in enumerate((gains[0], gains[0], gains[1])):
                pose[axis] += gain * change[axis]
        self.pose = self.past[tick]

    def _predict(self, tick: int) -> None:
        mean = self.twist
        if self.lag > 0.0:
            left = math.exp(-self._dt / self.lag)
            share = self.lag / self._dt * (1.0 - left)
            mean = tuple(u + (b - u) * share for u, b in zip(self.twist, self.body, strict=True))  # type: ignore[assignment]
            self.body = tuple(u + (b - u) * left for u, b in zip(self.twist, self.body, strict=True))  # type: ignore[assignment]
        speed, turn = mean
        x, y, heading = self.pose
        if abs(turn) < 1e-9:
            x, y = x + speed * self._dt * math.cos(heading), y + speed * self._dt * math.sin(heading)
        else:
            x += speed / turn * (math.sin(heading + turn * self._dt) - math.sin(heading))
            y -= speed / turn * (math.cos(heading + turn * self._dt) - math.cos(heading))
        self.pose = self.past[tick] = [x, y, heading + turn * self._dt]
        self.variance = [self.variance[0] + 0.04 * self._dt, self.variance[1] + 0.01 * self._dt]
