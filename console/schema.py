"""fes schema: the JSON schema of a scenario."""

from fes import process
from fes.settings.schema import json_schema
from fes.system import strict_json
from world.config.schema import ScenarioFile


def schema() -> int:
    """Print the JSON schema of a scenario: type, default, bounds, unit and description of each field."""
    print(strict_json.dumps(json_schema(ScenarioFile), indent=2))
    return process.SUCCESS
