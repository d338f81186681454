"""Version of the log, and the JSON schemas of its texts; messages.proto has its other messages."""

VERSION = 4
"""Version of the log as a whole: readers of another version cannot read it. Since 2 it names the arithmetic,
since 3 the extensions, since 4 the tick of each fix."""

READABLE = 3
"""Oldest version that is read: its payloads are those of the present one but for that tick (`fes.protocol.older`)."""

SCENARIO = {
    "title": "fes.Scenario",
    "type": "object",
    "description": "The scenario of a run, and the programs that ran it",
    "required": ["log", "name", "backend", "scenario", "arithmetic", "extensions", "versions"],
    "properties": {
        "log": {"type": "integer", "description": "version of the log's schemas"},
        "name": {"type": "string", "description": "name of the scenario"},
        "backend": {"type": "string"},
        "scenario": {"type": "string", "description": "the effective scenario, TOML"},
        "arithmetic": {
            "type": "object",
            "description": "fingerprint of the elementary functions, version of numpy, and the core in use",
        },
        "extensions": {"type": "array", "description": "kind, name and source of each extension, by its SHA-256"},
        "versions": {"type": "object", "description": "of fes, its libraries, Python and the machine"},
    },
}

EVENT = {
    "title": "fes.Event",
    "type": "object",
    "description": "An event at a tick, other than the steps of the robots",
    "required": ["tick", "what"],
    "properties": {
        "tick": {"type": "integer"},
        "what": {
            "enum": ["set", "present", "excluded", "end"],
            "description": "the channel was changed; robots joined or left, not by schedule; robots were "
            "excluded for a fault of theirs; the run is over",
        },
        "by": {"enum": ["schedule", "person"]},
        "path": {"type": "string", "description": "of a set: the field, by its dotted path in the scenario"},
        "value": {"description": "of a set: its new value"},
        "robots": {
            "type": "array",
            "items": {"type": "integer"},
            "description": "of present: all that take part now; of excluded: those",
        },
        "reason": {"type": "string", "description": "of an exclusion, or of an end before its time"},
    },
}
