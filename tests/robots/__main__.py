"""An ordinary robot of ROS 2, driven by `fes.ros`: `python -m tests.robots`; `run` beside it starts this.

Exit codes: 0 all claims hold, 1 a claim does not hold. The last line counts them.
"""

import asyncio
import math
import sys
import time
import traceback

from fes.ros.messages import PoseMessage
from fes.ros.types import TYPES
from tests.robots import codec
from tests.robots.drive import COMMANDS, FRAME, Drive, drive
from tests.robots.driver import FRAME as MAP
from tests.robots.stage import Robot, Stage, driven
from tests.support.session import client, router

ROBOTS = (
    Robot("robot3", "Twist", "Odometry"),
    Robot("robot4", "TwistStamped", "PoseStamped"),
    Robot("robot5", "Twist", "PoseWithCovarianceStamped"),
)


class Verdict:
    """Claims, counted and printed."""

    def __init__(self) -> None:
        self.begun = time.monotonic()
        self.passed = self.failed = 0

    def claim(self, holds: bool, words: str) -> None:
        """Count a claim."""
        self.passed, self.failed = self.passed + holds, self.failed + (not holds)
        print(
            f"robots: [{time.monotonic() - self.begun:.0f} s] {'passed' if holds else 'FAILED'}: {words}", flush=True
        )


def judge(verdict: Verdict, stage: Stage, done: Drive) -> None:
    """The claims about one drive."""
    robot = stage.robot
    name = f"{robot.name} ({robot.twist}, {robot.pose})"
    wanted = [TYPES[robot.twist].hash, TYPES[robot.pose].hash]
    verdict.claim(stage.hashes == wanted, f"{name}: the hashes that the node reports are ours")
    sent = [[linear, angular] for linear, angular, _ in done.sent]
    heard = [twist for twist in stage.heard if twist[0] != 0.0]
    places = [sent.index(twist[:2]) if twist[:2] in sent else -1 for twist in heard]
    arrived = -1 not in places and places == sorted(places) and set(places) == set(range(COMMANDS))
    verdict.claim(arrived, f"{name}: each of {COMMANDS} commands arrived, in order and to the digit")
    if robot.twist == "TwistStamped":
        marks = all(twist[2:] == [done.sent[place][2], FRAME] for twist, place in zip(heard, places, strict=True))
        verdict.claim(marks, f"{name}: with its time and its frame")
    judge_poses(verdict, name, stage, done.poses)


def judge_poses(verdict: Verdict, name: str, stage: Stage, poses: list[PoseMessage]) -> None:
    """The claims about the poses of one drive."""
    stamps = [pose.stamp for pose in poses]
    in_order = stamps == sorted(set(stamps)) and set(stamps) <= set(stage.published)
    verdict.claim(in_order, f"{name}: all {len(poses)} poses are among those that the node published, in order")
    if not in_order:
        return
    pairs = [(pose, stage.published[pose.stamp]) for pose in poses]
    equal = all([pose.x, pose.y] == own[:2] and pose.frame == MAP for pose, own in pairs)
    verdict.claim(equal, f"{name}: places are those of the node, to the digit")
    # sin, cos and atan2 round once each
    turned = all(math.isclose(pose.heading, own[2], abs_tol=1e-15, rel_tol=4e-16) for pose, own in pairs)
    verdict.claim(turned, f"{name}: headings are those of the node, to the last place")
    twists = [tuple(own[3:]) if stage.robot.pose == "Odometry" else None for _, own in pairs]
    verdict.claim([pose.twist for pose in poses] == twists, f"{name}: only Odometry has a twist, that of the node")
    verdict.claim(poses[-1].x > 0.1 and abs(poses[-1].heading) > 0.01, f"{name}: it moved and turned")


async def main() -> int:
    """Check all claims; returns the exit code."""
    verdict = Verdict()
    for holds, words in codec.claims():
        verdict.claim(holds, words)
    async with router() as (_, endpoint):
        for robot in ROBOTS:
            try:
                async with driven(robot, endpoint) as stage, client(endpoint) as bus:
                    judge(verdict, stage, await drive(bus, stage))
            except Exception:
                traceback.print_exc()
                verdict.claim(False, f"{robot.name}: the drive ends without an error")
    print(f"{verdict.passed} passed, {verdict.failed} failed", flush=True)
    return 1 if verdict.failed else 0


if __name__ == "__main__":
    sys.exit(asyncio.run(main()))
