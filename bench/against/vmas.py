"""VMAS's flocking: 1,000 environments of ten agents in one array program of torch, on one thread.

Its agents see obstacles by lidar, and collide. Each step has five sub-steps, observations and rewards. All settings
are VMAS's own, except the number of agents, and actions are drawn before the clock starts. Both programs step robots
that move, but they compute different things: the ratio is one of rates, not of equal work.
"""

from pathlib import Path

from bench.against import environments
from bench.against.programs import number

ENVIRONMENTS, AGENTS = 1000, 10

RATE = """
import sys, time
import torch

torch.set_num_threads(1)
from vmas import make_env

environments, agents, steps, skip = map(int, sys.argv[1:])
env = make_env(
    scenario="flocking", num_envs=environments, n_agents=agents, device="cpu", continuous_actions=True, seed=0
)
env.reset()
actions = [[env.get_random_action(agent) for agent in env.agents] for _ in range(8)]
for step in range(skip + steps):
    if step == skip:
        begun = time.process_time()
    env.step(actions[step % len(actions)])
print(environments * agents * steps / (time.process_time() - begun))
"""
"""Prints robot-steps per second of processor time."""


def rate(folder: Path, steps: int) -> float:
    """Robot-steps per second of processor time."""
    words: list[str | Path] = [environments.vmas(folder), "-c", RATE, str(ENVIRONMENTS), str(AGENTS), str(steps), "3"]
    return number(words, environments.ISOLATED, folder)
