"""A team in one loop that writes checkpoints and may die at any tick."""

from pathlib import Path

import numpy as np

from agents.control import crew
from agents.runtime import marshalling
from agents.runtime.reception import Receiver
from fes.model.sensing import no_beacons
from fes.protocol import messages
from tests.support import loop
from tests.support.loop import load
from world.config.scenario import Scenario, agent_config
from world.execution.checkpoint import FOLDER, CheckpointWriter
from world.execution.run import Answer, Run
from world.simulation import truth


class Team:
    """A crew in one loop with a run."""

    def __init__(self, scenario: Scenario) -> None:
        self.crew = crew.create(agent_config(scenario), np.arange(scenario.robots.number))
        self.minds, self.beacons, self.receiver = crew.start(self.crew), no_beacons(), Receiver()

    def step(self, run: Run) -> None:
        """Execute one tick."""
        anew = run.state.since == run.state.tick
        if anew.any() and run.state.tick > 0:
            self.minds = crew.forget(self.crew, self.minds, anew)
        sent = run.observations(run.state.present)
        inputs = self.receiver, truth.observe(run.state), self.beacons
        self.minds, self.beacons, twists, telemetry = loop.tick(self.crew, self.minds, *inputs)
        spoken = [payload for _, *payload in marshalling.encode_tick(self.beacons, twists, telemetry)]
        decodable = run.state.decodable.tolist()
        beacons = [beacon if good else b"" for (beacon, _), good in zip(spoken, decodable, strict=True)]
        answers: list[Answer | None] = [(messages.decode_command(command), command) for _, command in spoken]
        alive = (run.world.ids != run.state.tick % 3).astype(np.uint8)  # who hangs is alive; who is dead is not
        run.advance(sent, answers, beacons, alive, 0.1)
        run.record_tick()


def begun(where: Path) -> Path:
    """A run directory with a checkpoint."""
    where.mkdir()
    checkpoints = CheckpointWriter(where, 1e9, "pair", "main")
    run = Run(load("pair.toml"), note=checkpoints.note)
    checkpoints.begin(run)
    checkpoints.close(run)
    return where / FOLDER / "state"
