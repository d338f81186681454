"""The message types of a log: those that viewers know by name, and this project's own.

Fields and numbers of `foxglove.*` are those of Foxglove's public schemas, https://docs.foxglove.dev. Lengths are in
meters, angles in radians; times are simulated; a number that does not exist is NaN. docs/log.md has the topics.
"""

from fes.recording.protobuf import parse

VERSION = 2
"""Version of the log as a whole: readers of another version cannot read it. Since 2 it names the arithmetic."""

_TIME = parse(
    "google.protobuf",
    """
    message Timestamp { int64 seconds = 1; int32 nanos = 2; }
    message Duration { int64 seconds = 1; int32 nanos = 2; }
    """,
)

TIMESTAMP = _TIME["Timestamp"]

FOXGLOVE = parse(
    "foxglove",
    """
    message Vector3 { double x = 1; double y = 2; double z = 3; }
    message Point3 { double x = 1; double y = 2; double z = 3; }
    message Quaternion { double x = 1; double y = 2; double z = 3; double w = 4; }
    message Pose { Vector3 position = 1; Quaternion orientation = 2; }
    message Color { double r = 1; double g = 2; double b = 3; double a = 4; }
    message KeyValuePair { string key = 1; string value = 2; }

    message FrameTransforms { repeated FrameTransform transforms = 1; }
    message FrameTransform {
      Timestamp timestamp = 1; string parent_frame_id = 2; string child_frame_id = 3;
      Vector3 translation = 4; Quaternion rotation = 5;
    }

    message Log {
      enum Level { UNKNOWN = 0; DEBUG = 1; INFO = 2; WARNING = 3; ERROR = 4; FATAL = 5; }
      Timestamp timestamp = 1; Level level = 2; string message = 3; string name = 4; string file = 5;
      fixed32 line = 6;
    }

    message SceneUpdate { repeated SceneEntityDeletion deletions = 1; repeated SceneEntity entities = 2; }
    message SceneEntityDeletion {
      enum Type { MATCHING_ID = 0; ALL = 1; }
      Timestamp timestamp = 1; Type type = 2; string id = 3;
    }
    message SceneEntity {
      Timestamp timestamp = 1; string frame_id = 2; string id = 3; Duration lifetime = 4; bool frame_locked = 5;
      repeated KeyValuePair metadata = 6; repeated ArrowPrimitive arrows = 7; repeated CubePrimitive cubes = 8;
      repeated SpherePrimitive spheres = 9; repeated CylinderPrimitive cylinders = 10;
      repeated LinePrimitive lines = 11; repeated TriangleListPrimitive triangles = 12;
      repeated TextPrimitive texts = 13; repeated ModelPrimitive models = 14;
    }
    message ArrowPrimitive {
      Pose pose = 1; double shaft_length = 2; double shaft_diameter = 3; double head_length = 4;
      double head_diameter = 5; Color color = 6;
    }
    message CubePrimitive { Pose pose = 1; Vector3 size = 2; Color color = 3; }
    message SpherePrimitive { Pose pose = 1; Vector3 size = 2; Color color = 3; }
    message CylinderPrimitive {
      Pose pose = 1; Vector3 size = 2; double bottom_scale = 3; double top_scale = 4; Color color = 5;
    }
    message LinePrimitive {
      enum Type { LINE_STRIP = 0; LINE_LOOP = 1; LINE_LIST = 2; }
      Type type = 1; Pose pose = 2; double thickness = 3; bool scale_invariant = 4; repeated Point3 points = 5;
      Color color = 6; repeated Color colors = 7; repeated fixed32 indices = 8;
    }
    message TriangleListPrimitive {
      Pose pose = 1; repeated Point3 points = 2; Color color = 3; repeated Color colors = 4;
      repeated fixed32 indices = 5;
    }
    message TextPrimitive {
      Pose pose = 1; bool billboard = 2; double font_size = 3; bool scale_invariant = 4; Color color = 5;
      string text = 6;
    }
    message ModelPrimitive {
      Pose pose = 1; Vector3 scale = 2; Color color = 3; bool override_color = 4; string url = 5;
      string media_type = 6; bytes data = 7;
    }
    """,
    _TIME,
)

OWN = parse(
    "fes",
    """
    // The payloads of a tick as they crossed the bus, of all robots in the order of their ids
    message Observations { uint64 tick = 1; repeated bytes payloads = 2; }
    message Beacons { uint64 tick = 1; repeated bytes payloads = 2; }
    message Commands { uint64 tick = 1; repeated bytes payloads = 2; }

    // What observers are told, and the team's numbers in it
    message Report {
      uint64 tick = 1; bytes payload = 2; double optimal_separation = 3; double mean_estimate_error = 4;
      double disagreement = 5; double estimate_error_max = 6; double separation_error_max = 7; uint64 links = 8;
      uint64 beacons_sent = 9; uint64 beacons_decoded = 10;
    }

    message RobotState {
      double x = 1; double y = 2; double heading = 3; double linear = 4; double angular = 5;
      double estimate_mean = 6; // of its links
      double links = 7;
    }
    message LinkState {
      double separation = 1; double estimate_ij = 2; double estimate_ji = 3;
      double outage = 4;                              // true, of a beacon, mean of both ways
      double sent = 5; double decoded = 6; double longest_gap = 7;
      double learnt_reception = 8; double learnt_level = 9; double learnt_exponent = 10;
    }
    """,
)

SCENARIO = {
    "title": "fes.Scenario",
    "type": "object",
    "description": "What was run, and by what",
    "required": ["log", "name", "backend", "scenario", "arithmetic", "versions"],
    "properties": {
        "log": {"type": "integer", "description": "version of the log's schemas"},
        "name": {"type": "string", "description": "name of the scenario"},
        "backend": {"type": "string"},
        "scenario": {"type": "string", "description": "the effective scenario, TOML"},
        "arithmetic": {
            "type": "object",
            "description": "fingerprint of the elementary functions, version of numpy, and the core in use",
        },
        "versions": {"type": "object", "description": "of fes and of the libraries that its digits depend on"},
    },
}

EVENT = {
    "title": "fes.Event",
    "type": "object",
    "description": "Something that happened at a tick, beside what the robots did",
    "required": ["tick", "what"],
    "properties": {
        "tick": {"type": "integer"},
        "what": {
            "enum": ["set", "present", "excluded", "end"],
            "description": "the channel was changed; robots came or went otherwise than by schedule; robots were "
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
