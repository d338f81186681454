"""The layers of the packages, from the bottom up, and the packages that wait or communicate."""

LAYERS = (
    {"fes.errors", "fes.arrays"},
    {"fes.arithmetic"},
    {"fes.model", "fes.system"},
    {"fes.protocol", "fes.extension", "fes.ros", "fes.settings", "fes.shapes"},
    {"fes.transport", "fes.recording"},
    {"fes.process"},
    {"fes.command_line"},
    {"agents.configuration", "agents.laws", "agents.rivals", "world.config"},
    {"agents.control", "world.simulation"},
    {"agents.core"},
    {"agents.runtime", "field.radio", "field.senses", "world.metrics"},
    {"agents.process", "field.gate", "world.execution"},
    {"agents.__main__", "field.settings", "world.flags", "world.server", "world.tabletop"},
    {"field.runtime", "world.process"},
    {"field.process", "world.__main__", "console.guide", "console.schema", "console.terminal"},
    {"field.__main__"},
    {"console.keys", "console.measures"},
    {"console.connect"},
    {"console.foxglove"},
    {"console.web"},
    {"console.dashboard", "console.doctor"},
    {"console.backends", "console.replay"},
    {"console.analysis", "console.check", "console.team"},
    {"console.fit", "console.sweep"},
    {"console.api", "console.cli"},
    {"console.__main__"},
)
"""Sub-packages from the bottom up: each imports only from lower layers, never from its own.
In addition, agents and world do not import each other. `fes.extension.registry` loads a built-in extension of the
layers above by its dotted path, only where it is used."""

SHELLS = (
    "agents.runtime",
    "agents.process",
    "field.gate",
    "field.process",
    "field.radio",
    "field.runtime",
    "field.settings",
    "world.process",
    "world.server",
    "world.tabletop",
)
"""The only packages of an agent, a real robot or a world that import asyncio, or the transport."""
