"""A team in one loop that writes checkpoints and may die at any tick."""

from pathlib import Path

import numpy as np

from agents.control import crew
from agents.runtime import marshalling
from fes.model.sensing import no_beacons
from fes.protocol import messages
from tests.support.loop import load
from world.config.scenario import Scenario, agent_config
from world.execution.checkpoint import FOLDER, CheckpointWriter
from world.execution.run import Answer, Run
from world.simulation import truth


class Team:
    """A crew in one loop with a run."""

    def __init__(self, scenario: Scenario) -> None:
        self.crew = crew.create(agent_config(scenario), np.arange(scenario.robots.number))
        self.minds, self.beacons = crew.start(self.crew), no_beacons()

    def step(self, run: Run) -> None:
        """Execute one tick."""
        anew = run.state.since == run.state.tick
        if anew.any() and run.state.tick > 0:
            self.minds = crew.forget(self.crew, self.minds, anew)
        sent = run.observations(run.state.present)
        self.minds, self.beacons, twists = crew.step(self.crew, self.minds, truth.observe(run.state), self.beacons)
        telemetry = crew.telemetry(self.crew, self.minds)
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
