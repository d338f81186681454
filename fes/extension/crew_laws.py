"""The laws of a crew, by the settings of a run."""

from dataclasses import replace
from typing import Any, NamedTuple

from fes.errors import FesError
from fes.extension.context import LawContext
from fes.extension.controller_laws import ControllerFormation, ControllerSeeking
from fes.extension.kinds import CONTROLLER, FORMATION, RULE, SEEKING
from fes.extension.protocols import MAX_DECLARED, FormationLaw, NeighborRule, SeekingLaw
from fes.extension.registry import create, is_told, load, parameters
from fes.model.config import AgentConfig
from fes.model.seeking import MeasuredConfig, SeekingConfig
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
    is_sought_told = is_told(SEEKING, seeking) if isinstance(seeking, Use) else seeking.knows_channel
    return is_sought_told or is_told(FORMATION, formation)


def physical_period(config: SeekingConfig) -> float | None:
    """Period of the oscillation that the law imposes on the formation [s]; None without one.

    An extension may have a static method `physical_period(parameters)`. Raises FesError in one line.
    """
    if not isinstance(config, Use):
        return config.physical_period
    loaded = load(SEEKING, config.use)
    if not hasattr(loaded, "physical_period"):
        return None
    period: float | None = loaded.physical_period(parameters(SEEKING, config, loaded))
    return period


def laws(config: AgentConfig, context: LawContext) -> Laws:
    """The laws of a crew with `config`; raises FesError in one line.

    Only a law with `knows_channel` gets the channel. The values that laws of others return are checked at each call.
    """
    rule = create(RULE, config.formation.rule, context)
    if config.controller is not None:
        return Laws(rule, *_controllers(config.controller, context))
    formation = create(FORMATION, config.formation.law, context)
    is_own = isinstance(config.seeking, Use)
    if not isinstance(config.seeking, Use) and config.seeking.knows_channel and context.channel is None:
        # before its module, which knows the formula, is loaded
        raise FesError(
            f"seeking.index = '{config.seeking.index}' needs the channel, and this agent did not receive it"
        )
    choice = config.seeking if isinstance(config.seeking, Use) else _seeking_name(config.seeking)
    seeking = create(SEEKING, choice, context, None if is_own else config.seeking)
    declared = formation.declared + seeking.declared
    if declared > MAX_DECLARED:
        raise FesError(f"the laws declare {declared} bytes in each beacon: at most {MAX_DECLARED} are allowed")
    return Laws(rule, formation, seeking)


def _controllers(choice: str | Use, context: LawContext) -> tuple[ControllerFormation, ControllerSeeking]:
    """The two laws of a crew of controllers."""
    name = chosen(choice).use
    loaded = load(CONTROLLER, name)
    if not getattr(loaded, "knows_channel", False):
        context = replace(context, channel=None)
    checked = parameters(CONTROLLER, choice, loaded)
    formation = ControllerFormation(loaded, checked, context, f"{CONTROLLER.name} '{name}'")
    return formation, ControllerSeeking(loaded, context)


def _seeking_name(config: SeekingConfig) -> str:
    if isinstance(config, Use):
        return config.use
    return f"measured, {config.pooling}" if isinstance(config, MeasuredConfig) else config.index
