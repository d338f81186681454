"""The laws of a crew, by the settings of a run."""

from dataclasses import replace
from typing import Any, NamedTuple

from fes.errors import FesError
from fes.extension import evidence
from fes.extension.checked import Checked
from fes.extension.context import LawContext
from fes.extension.controller_laws import ControllerFormation, ControllerSeeking
from fes.extension.evidence import Evidence
from fes.extension.kinds import CONTROLLER, FORMATION, RULE, SEEKING, Kind
from fes.extension.protocols import FormationLaw, NeighborRule, SeekingLaw
from fes.extension.registry import create, is_told, load, parameters
from fes.model.config import AgentConfig, FormationConfig
from fes.model.seeking import MeasuredConfig, OracleConfig, SampledConfig, SeekingConfig
from fes.model.sensing import MAX_DECLARED
from fes.model.table import Use, chosen


class Laws(NamedTuple):
    """The laws of a crew."""

    rule: NeighborRule
    formation: FormationLaw[Any]
    seeking: SeekingLaw[Any]


def knows_channel(seeking: SeekingConfig, formation: str | Use, controller: str | Use | None) -> bool:
    """True if one of these laws must be told the channel; no built-in law is loaded. Raises FesError in one line."""
    if controller is not None:
        return is_told(CONTROLLER, controller)
    is_seeking_told = is_told(SEEKING, seeking) if isinstance(seeking, Use) else seeking.knows_channel
    return is_seeking_told or is_told(FORMATION, formation)


def physical_period(config: SeekingConfig) -> float | None:
    """Period of the oscillation that the law imposes on the formation [s]; None without one.

    An extension may have a static method `physical_period(parameters)`. Raises FesError in one line.
    """
    if not isinstance(config, Use):
        return config.physical_period
    loaded = load(SEEKING, config.use)
    if not hasattr(loaded, "physical_period"):
        return None
    law = Checked(loaded, f"{SEEKING.name} '{config.use}'")
    period: Any = law.call(loaded.physical_period, parameters(SEEKING, config, loaded))
    if period is not None and not (isinstance(period, int | float) and 0.0 < period < float("inf")):
        law.fail(f"physical_period must return a positive time or None, got {period!r:.60}")
    return None if period is None else float(period)


def laws(config: AgentConfig, context: LawContext) -> Laws:
    """The laws of a crew with `config`; raises FesError in one line.

    Only a law with `knows_channel` gets the channel. The values that extensions return are checked at each call.
    """
    rule = create(RULE, config.formation.rule, context, _settled(RULE, config.formation.rule, config))
    if config.controller is not None:
        return Laws(rule, *_controllers(config, context))
    law = config.formation.acting_law
    circumstances = _context_of(FORMATION, law, config, context)
    formation = create(FORMATION, law, circumstances, _settled(FORMATION, law, config))
    given = None if isinstance(config.seeking, Use) else config.seeking
    choice = config.seeking if isinstance(config.seeking, Use) else _built_in_name(config.seeking)
    seeking = create(SEEKING, choice, _context_of(SEEKING, choice, config, context), given)
    declared = formation.declared + seeking.declared
    if declared > MAX_DECLARED:
        raise FesError(f"the laws declare {declared} bytes in each beacon: at most {MAX_DECLARED} are allowed")
    return Laws(rule, formation, seeking)


def evidence_of(config: AgentConfig) -> list[Evidence]:
    """The evidence of all extensions that a crew with `config` uses, built-in ones aside; raises FesError."""
    choices: list[tuple[Kind, str | Use]] = [(RULE, config.formation.rule)]
    if config.controller is not None:
        choices.append((CONTROLLER, config.controller))
    else:
        choices.append((FORMATION, config.formation.acting_law))
        choices += [(SEEKING, config.seeking)] if isinstance(config.seeking, Use) else []
    outside = [(kind, chosen(choice).use) for kind, choice in choices if chosen(choice).use not in kind.built_in]
    return [evidence.of(kind, name, load(kind, name)) for kind, name in outside]


def _settled(kind: Kind, choice: str | Use, config: AgentConfig) -> FormationConfig | None:
    """The table [formation], for a built-in rule or law whose parameters stand in it; None for every other."""
    return config.formation if chosen(choice).use in kind.settled else None


def _context_of(kind: Kind, choice: str | Use, config: AgentConfig, context: LawContext) -> LawContext:
    """The context for a law or a controller: with the channel if it must be told. Raises FesError without one."""
    if not is_told(kind, choice):
        return context
    if config.channel is None:
        name = chosen(choice).use
        raise FesError(f"{kind.name} '{name}' needs the channel, and this agent did not receive it")
    from fes.extension.told_channel import ToldChannel  # imported here only: it knows the formula

    return replace(context, channel=ToldChannel(config.channel))


def _controllers(config: AgentConfig, context: LawContext) -> tuple[ControllerFormation, ControllerSeeking]:
    """The two laws of a crew of controllers."""
    assert config.controller is not None
    choice = config.controller
    loaded = load(CONTROLLER, chosen(choice).use)
    checked = parameters(CONTROLLER, choice, loaded)
    context = _context_of(CONTROLLER, choice, config, context)
    formation = ControllerFormation(loaded, checked, context, f"{CONTROLLER.name} '{chosen(choice).use}'")
    return formation, ControllerSeeking(loaded, context)


def _built_in_name(config: OracleConfig | MeasuredConfig | SampledConfig) -> str:
    return f"measured, {config.pooling}" if isinstance(config, MeasuredConfig) else config.index
