"""The scenario: one TOML file, typed, frozen and complete."""

from pathlib import Path
from typing import Any, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from fes.arithmetic import draws
from fes.arrays.types import Floats
from fes.errors import FesError, ScenarioError
from fes.extension import crew_laws, registry
from fes.extension.kinds import CHANNEL, CONTROLLER, DYNAMICS, FORMATION, METRIC, RULE, SEEKING, Kind
from fes.model import counts, stability
from fes.model.config import FORMULAS, AgentConfig, FaultConfig, FormationConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig, SeekingConfig
from fes.model.table import Table, Use, chosen
from fes.settings import toml
from fes.settings.validation import first_rule
from fes.shapes import rules
from world.config import events, expectations, faults, starts
from world.config.events import EventConfig, ParticipationChange, changed, schedule
from world.config.expectations import ExpectConfig, MetricConfig
from world.config.faults import Transmission
from world.config.hardware.tabletop import TabletopConfig
from world.config.outside import schemes, trace_file
from world.config.overrides import apply
from world.config.overrides import parse_override as parse_override
from world.config.radio import RadioConfig
from world.config.starts import LocalizationConfig, RobotsConfig, SensingConfig
from world.config.timing import RunConfig


class Scenario(Table):
    """A scenario: robots, channel, laws, events and expectations of a run."""

    schema_version: int = Field(alias="schema", ge=1, le=1)
    """Version of the scenario format."""
    run: RunConfig = RunConfig()
    """Duration, tick, seed and clock."""
    robots: RobotsConfig
    """Number, initial poses and bodies of the robots."""
    sensing: SensingConfig = SensingConfig()
    """Sensing of the robots' own poses."""
    localization: LocalizationConfig = LocalizationConfig()
    """The robots' way from fixes to poses."""
    channel: RadioConfig = RadioConfig()
    """The radio channel."""
    objective: ObjectiveConfig = ObjectiveConfig()
    """The separations that the team prefers."""
    seeking: SeekingConfig = OracleConfig()
    """The seeking law."""
    formation: FormationConfig = FormationConfig()
    """The formation law and its graph."""
    tabletop: TabletopConfig | None = None
    """A team of small robots on a table; only fes-tabletop reads it."""
    metric: list[MetricConfig] = Field(default=[])
    """Further metrics of the summary."""
    event: list[EventConfig] = Field(default=[])
    """Changes during the run."""
    expect: list[ExpectConfig] = Field(default=[])
    """Expectations of the summary at the end of the run."""

    @model_validator(mode="after")
    def _stable(self) -> Self:
        stability.check(self.run.dt, self.seeking, self.formation, self.objective)
        self.sensing.check(self.run.dt)
        rules.check(self.formation, self.seeking, self.run.dt, self.robots.number)
        if self.robots.controller is not None and self.formation.configuration != "none":
            raise ValueError("robots.controller and formation.configuration exclude each other")
        return self

    @model_validator(mode="after")
    def _channel_at_all_times(self) -> Self:
        self.channel.check(self.run.dt)
        robots = self.robots.number
        try:
            channels = self.channels
        except ScenarioError as error:
            raise ValueError(f"event: set {error}") from None
        for channel in channels:
            channel.check_partition(robots)
            rules.check_range(self.formation, channel.communication_range)
        try:
            events.participation(self.event, robots, self.run.dt)
            events.parts(self.event, robots, self.run.dt)
        except ScenarioError as error:
            raise ValueError(str(error)) from None
        return self

    @field_validator("metric")
    @classmethod
    def _metrics_named_once(cls, metrics: list[MetricConfig]) -> list[MetricConfig]:
        names = [metric.key for metric in metrics]
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"two metrics have the name '{twice[0]}' in the summary: give one another `name`")
        return metrics

    @model_validator(mode="after")
    def _extensions(self) -> Self:
        for path, kind, choice in self.choices:
            try:
                registry.check(kind, choice)
            except FesError as error:
                raise ValueError(f"{path}: {error}") from None
        unknown = [channel.model for channel in self.channels if channel.model not in FORMULAS]
        if unknown and knows_channel(self):
            raise ValueError(
                f"a law is told the channel, and channel.model '{chosen(unknown[0]).use}' has no formula"
            )
        return self

    @model_validator(mode="after")
    def _expected(self) -> Self:
        expectations.check(self.expect, self.run.clock == "live", self.has_team_index)
        return self

    @property
    def has_team_index(self) -> bool:
        """True if the team index is computed: a configuration is sought, or the objective asks for it."""
        return self.objective.team_index or self.formation.configuration != "none"

    @property
    def choices(self) -> list[tuple[str, Kind, str | Use]]:
        """Every choice of an extension: its path, its kind, and what is chosen. A choice may be built in."""
        controller = self.robots.controller
        return [
            ("formation.rule", RULE, self.formation.rule),
            ("formation.law", FORMATION, self.formation.law),
            *([("seeking", SEEKING, self.seeking)] if isinstance(self.seeking, Use) else []),
            ("robots.dynamics", DYNAMICS, self.robots.dynamics),
            *([("robots.controller", CONTROLLER, controller)] if controller is not None else []),
            *(("channel.model", CHANNEL, channel.model) for channel in self.channels),
            *(("metric", METRIC, metric.choice) for metric in self.metric),
        ]

    @property
    def channels(self) -> list[RadioConfig]:
        """The channel at the start and after each scheduled change, in order; raises ScenarioError."""
        channels = [self.channel]
        for settings in self.changes.values():
            channels.append(changed(channels[-1], settings, self.run.dt))
        return channels

    @property
    def changes(self) -> dict[int, dict[str, Any]]:
        """Tick -> settings of the channel from that tick on, in order."""
        return schedule(self.event, self.run.dt)

    @property
    def participation(self) -> dict[int, ParticipationChange]:
        """Tick -> change of participation, in order."""
        return events.participation(self.event, self.robots.number, self.run.dt)

    @property
    def world_deaths(self) -> dict[int, float]:
        """Tick of the world's death -> time until another world resumes [s; wall clock], in order."""
        deaths = [(event.at, event.world_away) for event in self.event if event.world_away is not None]
        return dict(sorted({counts.ticks(time, self.run.dt): away for time, away in deaths}.items()))

    @property
    def transmissions(self) -> dict[int, Transmission | None]:
        """Tick -> effect of the transmitters from that tick on, in order; None if all are healthy."""
        robots = self.robots.number
        return faults.transmissions(events.parts(self.event, robots, self.run.dt), robots)

    @property
    def faults(self) -> list[FaultConfig]:
        """Faults that the agents emulate, in order of time."""
        return faults.agent_faults(events.parts(self.event, self.robots.number, self.run.dt), self.run.dt)

    @property
    def ticks(self) -> int:
        """Number of ticks of the run."""
        return counts.ticks_of(self.run.duration, self.run.dt)


def load(path: Path, overrides: dict[str, Any] | None = None) -> Scenario:
    """The scenario in a TOML file, with `overrides` by dotted path; `scheme` among them chooses one of its schemes.

    Raises ScenarioError: one line that names the field, the rule and the offending value.
    """
    tables = toml.read(path)
    compared = schemes.take(tables, str(path))
    settings = trace_file.anchored(overrides or {}, Path.cwd())
    if schemes.SCHEME in settings:
        of_scheme = compared.settings(settings.pop(schemes.SCHEME), str(path))
        settings = trace_file.anchored(of_scheme, path.parent) | settings
    apply(tables, settings)
    trace_file.locate(tables, path.parent, str(path))
    return parse(tables, str(path))


def with_overrides(scenario: Scenario, overrides: dict[str, Any]) -> Scenario:
    """The scenario with `overrides` by dotted path; raises ScenarioError as `load` does."""
    tables, folder = scenario.model_dump(by_alias=True), Path.cwd()
    apply(tables, trace_file.anchored(overrides, folder))
    trace_file.locate(tables, folder, "scenario")
    return parse(tables, "scenario")


def parse(tables: dict[str, Any], where: str) -> Scenario:
    """The scenario of parsed TOML `tables`; raises ScenarioError, which names their origin `where`."""
    try:
        return Scenario.model_validate(tables)
    except ValidationError as error:
        raise ScenarioError(where, first_rule(error, Scenario, "scenario")) from None


def with_event(scenario: Scenario, tick: int, path: str, value: Any) -> Scenario:
    """The scenario with one more event for a change set during the run, so that the run can be repeated.

    Raises ScenarioError if the change makes a later event impossible.
    """
    event = {"at": round(tick * scenario.run.dt, 9), "set": {path: value}}
    tables = scenario.model_dump(by_alias=True)
    return parse({**tables, "event": [*tables["event"], event]}, f"{path}, with the scheduled events")


def agent_config(scenario: Scenario) -> AgentConfig:
    """The settings that an agent receives."""
    return AgentConfig(
        dt=scenario.run.dt,
        seed=draws.sub_seed(scenario.run.seed, "agents"),
        objective=scenario.objective,
        seeking=scenario.seeking,
        formation=scenario.formation,
        channel=scenario.channel.formula if knows_channel(scenario) else None,
        sensors=starts.data_sheet(scenario.robots, scenario.sensing),
        localization=scenario.localization,
        clock=scenario.run.clock,
        clock_skew=scenario.run.clock_skew,
        faults=scenario.faults,
        controller=scenario.robots.controller,
    )


def knows_channel(scenario: Scenario) -> bool:
    """True if a law of the robots is told the channel."""
    return crew_laws.knows_channel(scenario.seeking, scenario.formation.law, scenario.robots.controller)


def initial_poses(scenario: Scenario) -> Floats:
    """Poses at tick 0 [n, 3] [m, m, rad; world frame]."""
    return starts.poses(scenario.robots, scenario.run.seed)
