"""The tables of a configuration, and the kinds of numbers in them."""

import math
import reprlib
from typing import Annotated, Any, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

Exponent = Annotated[float, Field(gt=0, le=20, allow_inf_nan=False)]
"""Bounded, so that powers stay finite; larger exponents have no use."""

Cutoff = Annotated[float, Field(gt=0, le=1e4, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Table(BaseModel):
    """A table of a scenario: frozen, complete, strict."""

    # Without use_attribute_docstrings, which parses the source at each start: fes.settings.schema reads it on demand.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class OwnTable(Table):
    """A table that fes itself defines. Its validator is built at the first use, not at each start of a process.

    The table that holds it usually contains that validator already. A table of an extension is built at once, so that
    an error in it is reported when its module is imported.
    """

    model_config = ConfigDict(defer_build=True)


class Use(OwnTable):
    """An extension and its parameters: all keys of the table but `use` are parameters of the extension."""

    model_config = ConfigDict(extra="allow")

    use: str = Field(min_length=1, max_length=200)
    """Name of an extension: a built-in one, one that is installed, or `module:Class`."""

    @model_validator(mode="after")
    def _lasting(self) -> Self:
        for name, value in self.parameters.items():
            _check_lasting(name, value)
        return self

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters, which the extension itself checks."""
        return dict(self.model_extra or {})


def _check_lasting(name: str, value: object) -> None:
    """Raise ValueError unless a parameter is the same after it was written as TOML and as JSON."""
    if isinstance(value, dict):
        for key, part in value.items():
            _check_lasting(f"{name}.{key}", part)
    elif isinstance(value, list):
        for place, part in enumerate(value):
            _check_lasting(f"{name}.{place}", part)
    elif not isinstance(value, str | int) and not (isinstance(value, float) and math.isfinite(value)):
        raise ValueError(
            f"{name}: must be a finite number, a text, true or false, a list or a table, got {reprlib.repr(value)}"
        )


Name = Annotated[str, Field(min_length=1, max_length=200)]


def _tag(choice: Any) -> str:
    return "use=" if isinstance(choice, dict | Use) else "name="


def _shortest(choice: str | Use) -> str | Use:
    return choice.use if isinstance(choice, Use) and not choice.parameters else choice


Choice: TypeAlias = Annotated[
    Annotated[Name, Tag("name=")] | Annotated[Use, Tag("use=")], Discriminator(_tag), AfterValidator(_shortest)
]
"""An extension by its name alone, or as a table with its parameters. A table without parameters becomes the name."""


def chosen(choice: str | Use) -> Use:
    """The choice as a table.

    >>> chosen("disk").use, chosen("disk").parameters
    ('disk', {})
    """
    return choice if isinstance(choice, Use) else Use(use=choice)
