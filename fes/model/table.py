"""The tables of a configuration, and the kinds of numbers in them."""

from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

Exponent = Annotated[float, Field(gt=0, le=20, allow_inf_nan=False)]
"""Bounded, so that powers stay finite; larger exponents have no use."""

Cutoff = Annotated[float, Field(gt=0, le=1e4, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Table(BaseModel):
    """A table of a scenario: frozen, complete, strict."""

    # Without use_attribute_docstrings, which parses the source at each start: world.config.schema reads it on demand.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Use(Table):
    """An extension and its parameters: all keys of the table but `use` are parameters of the extension."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True)

    use: str = Field(min_length=1, max_length=200)
    """Name of an extension: a built-in one, one that is installed, or `module:Class`."""

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters, which the extension itself checks."""
        return dict(self.model_extra or {})


Name = Annotated[str, Field(min_length=1, max_length=200)]

Choice: TypeAlias = Name | Use
"""An extension by its name alone, or as a table with its parameters."""


def chosen(choice: str | Use) -> Use:
    """The choice as a table.

    >>> chosen("disk").use, chosen("disk").parameters
    ('disk', {})
    """
    return choice if isinstance(choice, Use) else Use(use=choice)
