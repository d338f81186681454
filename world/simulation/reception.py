"""The reception model of a channel: a built-in one or an extension, made once per class and setting."""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from fes.arithmetic import draws
from fes.extension import registry
from fes.extension.context import SeededDraws, WorldContext
from fes.extension.kinds import CHANNEL
from fes.model.table import chosen
from world.config.outside import trace_file
from world.config.radio import RadioConfig
from world.config.scenario import Scenario

_EFFECTS = {"shadowing", "bursts", "jammers", "partition", "communication_range"}
"""Settings of the radio that no reception model reads."""


def context(scenario: Scenario) -> WorldContext:
    """The circumstances of a channel, a body or a metric."""
    seed = draws.sub_seed(scenario.run.seed, "extensions")
    return WorldContext(scenario.run.dt, scenario.robots.number, scenario.objective, SeededDraws(seed))


def model(config: RadioConfig, context: WorldContext) -> Any:
    """The reception model of a channel; raises FesError in one line."""
    loaded = registry.load(CHANNEL, chosen(config.model).use)
    return _made(loaded, config.model_dump_json(exclude=_EFFECTS), context)


def prepare(channels: Iterable[RadioConfig], context: WorldContext) -> None:
    """Create the models of a run before its first tick, so that no channel ends it later; raises FesError."""
    for config in channels:
        if config.trace is not None and config.trace_sha256 is not None:
            trace_file.read(config.trace, config.trace_sha256)  # it may have changed since the model was created
        model(config, context)


@lru_cache(maxsize=8)  # more than the channels of a run have: a model may hold a large file
def _made(loaded: type, settings: str, context: WorldContext) -> Any:
    """The model of a class: one that is defined again under its name, as in a notebook, is made again."""
    config = RadioConfig.model_validate_json(settings)
    return registry.create(CHANNEL, config.model, context, config)


class Reception:
    """The model of the channel in force: made anew only when the channel changes."""

    def __init__(self, context: WorldContext) -> None:
        self.context = context
        self._config: RadioConfig | None = None
        self._model: Any = None

    def of(self, config: RadioConfig) -> Any:
        """The reception model of a channel."""
        if config is not self._config:
            self._config, self._model = config, model(config, self.context)
        return self._model
