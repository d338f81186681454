"""fes schema: the JSON schema of a scenario."""

from fes import process
from fes.system import strict_json
from world.config.scenario import Scenario


def schema() -> int:
    """Print the JSON schema of a scenario: each field's type, default, bounds and meaning."""
    print(strict_json.dumps(Scenario.model_json_schema(), indent=2))
    return process.SUCCESS
