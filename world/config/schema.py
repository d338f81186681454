"""The tables of a scenario file, with its schemes: the root of its fields and of its JSON schema."""

from pydantic import ConfigDict

from world.config.outside.schemes import Comparison
from world.config.scenario import Scenario


class ScenarioFile(Comparison, Scenario):
    """The tables of a scenario file: a scenario, its schemes, and the columns of their comparison."""

    model_config = ConfigDict(title="Scenario")
