"""fes schema: the JSON schema of a scenario."""

from fes import process
from fes.system import strict_json
from world.config.schema import json_schema


def schema() -> int:
    """Print the JSON schema of a scenario: type, default, bounds, unit and description of each field."""
    print(strict_json.dumps(json_schema(), indent=2))
    return process.SUCCESS
