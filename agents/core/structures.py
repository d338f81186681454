"""The structures of crew.h, field by field in its order."""

import ctypes
from ctypes import c_double, c_int64, c_void_p

NODES = 5


class Step(ctypes.Structure):
    """The linear part of (18) over a sub-step."""

    _fields_ = (
        ("nodes", c_double * NODES),
        ("washout_start", c_double * (NODES + 1)),
        ("washout_input", c_double * NODES * (NODES + 1)),
        ("path_start", c_double * 3 * (NODES + 2)),
        ("path_input", c_double * NODES * (NODES + 2)),
    )


class Objective(ctypes.Structure):
    """The preference S(r) of (16)."""

    _fields_ = (
        ("minimum_separation", c_double),
        ("maximum_separation", c_double),
        ("shape_exponent", c_double),
        ("share_of_reach", c_double),
    )


class Method(ctypes.Structure):
    """A learner of the channel."""

    _fields_ = (
        ("short_share", c_double),
        ("long_share", c_double),
        ("slope_prior", c_double * 2),
        ("slopes", c_double * 2),
        ("gain", c_double),
        ("scale", c_double),
    )


class Constants(ctypes.Structure):
    """The constants of a crew: `Crew` in crew.h."""

    _fields_ = (
        ("robots", c_int64),
        ("ids", c_void_p),
        ("first", c_void_p),
        ("estimate_keys", c_void_p),
        ("stagger_keys", c_void_p),
        ("dt", c_double),
        ("timeout", c_int64),
        ("rule", c_int64),
        ("tolerance", c_double),
        ("seeking", c_int64),
        ("statistics", c_int64),
        ("low_estimate", c_double),
        ("high_estimate", c_double),
        ("dither_amplitude", c_double),
        ("dither_frequency", c_double),
        ("consensus_gain", c_double),
        ("extrapolates", c_int64),
        ("sub_steps", c_int64),
        ("index_gain", c_double),
        ("coupled", Step),
        ("alone", Step),
        ("index", c_void_p),
        ("index_settings", c_void_p),
        ("objective", Objective),
        ("method", Method),
        ("linear_gain", c_double),
        ("angular_gain", c_double),
        ("linear_limit", c_double),
        ("angular_limit", c_double),
        ("safe_separation", c_double),
        ("separation_gain", c_double),
        ("give_way_gain", c_double),
    )


class BeaconArrays(ctypes.Structure):
    """The beacons of one tick: `Beacons` in crew.h."""

    _fields_ = (
        ("count", c_int64),
        ("ids", c_void_p),
        ("poses", c_void_p),
        ("begin", c_void_p),
        ("peers", c_void_p),
        ("estimates", c_void_p),
        ("selected", c_void_p),
        ("statistics", c_void_p),
    )


class Input(ctypes.Structure):
    """The inputs of a tick."""

    _fields_ = (
        ("tick", c_int64),
        ("poses", c_void_p),
        ("skew", c_void_p),
        ("begin", c_void_p),
        ("in_range", c_void_p),
        ("reception", c_void_p),
        ("beacons", BeaconArrays),
    )


class Messages(ctypes.Structure):
    """The messages of one process at a tick: `Messages` in wire.h."""

    _fields_ = (
        ("version", c_int64),
        ("since", c_void_p),
        ("observations", c_void_p),
        ("observation_lengths", c_void_p),
        ("senders", c_int64),
        ("beacons", c_void_p),
        ("beacon_lengths", c_void_p),
        ("pairs", c_int64),
        ("links", c_int64),
        ("poses", c_void_p),
        ("begin", c_void_p),
        ("in_range", c_void_p),
        ("reception", c_void_p),
        ("sender_ids", c_void_p),
        ("link_begin", c_void_p),
        ("link_peers", c_void_p),
        ("sender_poses", c_void_p),
        ("estimates", c_void_p),
        ("statistics", c_void_p),
        ("selected", c_void_p),
        ("is_model_free", c_int64),
        ("out", c_void_p),
        ("ends", c_void_p),
    )
