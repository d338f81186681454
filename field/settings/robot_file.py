"""robot.toml: all settings of a real robot. One file serves a team: `{robot}` in a topic stands for the id."""

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError, model_validator

from fes.errors import FesError, ScenarioError
from fes.extension import crew_laws, registry
from fes.extension.kinds import CONTROLLER, FORMATION, RULE, SEEKING
from fes.model import stability
from fes.model.config import AgentConfig, FormationConfig, LocalizationConfig, ObjectiveConfig, SensorConfig
from fes.model.seeking import MeasuredConfig, SeekingConfig
from fes.model.table import Choice, Table, Use
from fes.protocol import keys
from fes.settings import toml
from fes.settings.validation import first_rule
from field.settings.body import BodyConfig, LimitsConfig, TeamConfig
from field.settings.radio import RadioConfig

JUMPS = 6.0
"""Least distance between two poses that counts as a jump, in standard deviations of a fix."""

TickLength = Annotated[float, Field(ge=0.005, le=1.0)]


class RobotFile(Table):
    """The settings of a real robot."""

    schema_version: int = Field(alias="schema", ge=1, le=1)
    """Version of the format."""
    run: str = keys.DEFAULT_RUN
    """Name of the team's run, a part of every key."""
    id: Annotated[int, Field(ge=0, lt=keys.MAX_ROBOTS)] | None = None
    """Id of the robot; `fes-robot --id` overrides it."""
    dt: TickLength = 0.02
    """Tick length [s]; the same for the whole team."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    """Seed of the robots' own draws, such as first estimates; the same for the whole team."""
    objective: ObjectiveConfig = ObjectiveConfig()
    """The separations that the team prefers."""
    seeking: SeekingConfig = MeasuredConfig(index="measured")
    """The seeking law, which is not told the channel."""
    formation: FormationConfig = FormationConfig()
    """The formation law and its graph."""
    controller: Choice | None = None
    """A whole robot in plain Python, which replaces both laws; none by default."""
    sensing: SensorConfig = SensorConfig()
    """Data sheet of the pose sensor, and the lag of the body."""
    localization: LocalizationConfig = LocalizationConfig()
    """The filter between the sensor and the law."""
    body: BodyConfig = BodyConfig()
    """The robot's driver, and its place in the team's frame."""
    limits: LimitsConfig = LimitsConfig()
    """Limits of the gate."""
    radio: RadioConfig = RadioConfig()
    """The network of the beacons."""
    team: TeamConfig = TeamConfig()
    """The network of operator and observers."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        keys_of(self.run)
        stability.check(self.dt, self.seeking, self.formation, self.objective)
        for kind, choice in self._choices:
            try:
                registry.check(kind, choice)
            except FesError as error:
                raise ValueError(f"{kind.name}: {error}") from None
        if self.dt >= self.limits.command_timeout:
            raise ValueError(
                f"dt must be below limits.command_timeout, got {self.dt:g} and {self.limits.command_timeout:g}"
            )
        least = JUMPS * self.sensing.pose_noise / self.body.scale
        if self.limits.pose_jump < least:
            raise ValueError(
                f"limits.pose_jump must be at least {JUMPS:g} sensing.pose_noise / body.scale = {least:g}, "
                f"got {self.limits.pose_jump:g}"
            )
        if crew_laws.knows_channel(self.seeking, self.formation.law, self.controller):
            raise ValueError("a law that is told the channel cannot run on a real robot, whose channel is unknown")
        return self

    @property
    def _choices(self) -> list[tuple[Any, str | Use]]:
        """The extensions that the laws name."""
        chosen: list[tuple[Any, str | Use]] = [(FORMATION, self.formation.law), (RULE, self.formation.rule)]
        if isinstance(self.seeking, Use):
            chosen.append((SEEKING, self.seeking))
        if self.controller is not None:
            chosen.append((CONTROLLER, self.controller))
        return chosen

    @property
    def within_limits(self) -> FormationConfig:
        """The formation law, whose twists the gate need not clip: the robot then knows which twist is in force."""
        linear, angular = self.body.scale * self.limits.linear, self.limits.angular
        own = self.formation
        limits = {
            "linear_limit": linear if own.linear_limit is None else min(own.linear_limit, linear),
            "angular_limit": angular if own.angular_limit is None else min(own.angular_limit, angular),
        }
        return own.model_copy(update=limits)

    @property
    def agent_config(self) -> AgentConfig:
        """The settings of the crew."""
        return AgentConfig(
            dt=self.dt,
            seed=self.seed,
            objective=self.objective,
            seeking=self.seeking,
            formation=self.within_limits,
            channel=None,
            controller=self.controller,
            clock="live",
            sensors=self.sensing,
            localization=self.localization,
        )


def keys_of(run: str) -> None:
    """Raise ValueError unless `run` can be part of a key."""
    try:
        keys.check_run(run)
    except FesError as error:
        raise ValueError(str(error)) from None


def load(path: Path, robot: int | None = None) -> RobotFile:
    """The settings in a file, of this `robot` if one is given; raises ScenarioError in one line."""
    tables = toml.read(path)
    if robot is not None:
        tables["id"] = robot
    return parse(tables, str(path))


def parse(tables: dict[str, Any], where: str) -> RobotFile:
    """The settings in `tables`; raises ScenarioError, which names their origin `where`."""
    try:
        return RobotFile.model_validate(tables)
    except ValidationError as error:
        raise ScenarioError(where, first_rule(error, RobotFile, "robot.toml")) from None
