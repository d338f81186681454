from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Observations(_message.Message):
    __slots__ = ("tick", "payloads")
    TICK_FIELD_NUMBER: _ClassVar[int]
    PAYLOADS_FIELD_NUMBER: _ClassVar[int]
    tick: int
    payloads: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, tick: _Optional[int] = ..., payloads: _Optional[_Iterable[bytes]] = ...) -> None: ...

class Beacons(_message.Message):
    __slots__ = ("tick", "payloads")
    TICK_FIELD_NUMBER: _ClassVar[int]
    PAYLOADS_FIELD_NUMBER: _ClassVar[int]
    tick: int
    payloads: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, tick: _Optional[int] = ..., payloads: _Optional[_Iterable[bytes]] = ...) -> None: ...

class Commands(_message.Message):
    __slots__ = ("tick", "payloads")
    TICK_FIELD_NUMBER: _ClassVar[int]
    PAYLOADS_FIELD_NUMBER: _ClassVar[int]
    tick: int
    payloads: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, tick: _Optional[int] = ..., payloads: _Optional[_Iterable[bytes]] = ...) -> None: ...

class Report(_message.Message):
    __slots__ = ("tick", "payload", "optimal_separation", "mean_estimate_error", "disagreement", "estimate_error_max", "separation_error_max", "links", "beacons_sent", "beacons_decoded")
    TICK_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_FIELD_NUMBER: _ClassVar[int]
    OPTIMAL_SEPARATION_FIELD_NUMBER: _ClassVar[int]
    MEAN_ESTIMATE_ERROR_FIELD_NUMBER: _ClassVar[int]
    DISAGREEMENT_FIELD_NUMBER: _ClassVar[int]
    ESTIMATE_ERROR_MAX_FIELD_NUMBER: _ClassVar[int]
    SEPARATION_ERROR_MAX_FIELD_NUMBER: _ClassVar[int]
    LINKS_FIELD_NUMBER: _ClassVar[int]
    BEACONS_SENT_FIELD_NUMBER: _ClassVar[int]
    BEACONS_DECODED_FIELD_NUMBER: _ClassVar[int]
    tick: int
    payload: bytes
    optimal_separation: float
    mean_estimate_error: float
    disagreement: float
    estimate_error_max: float
    separation_error_max: float
    links: int
    beacons_sent: int
    beacons_decoded: int
    def __init__(self, tick: _Optional[int] = ..., payload: _Optional[bytes] = ..., optimal_separation: _Optional[float] = ..., mean_estimate_error: _Optional[float] = ..., disagreement: _Optional[float] = ..., estimate_error_max: _Optional[float] = ..., separation_error_max: _Optional[float] = ..., links: _Optional[int] = ..., beacons_sent: _Optional[int] = ..., beacons_decoded: _Optional[int] = ...) -> None: ...

class RobotState(_message.Message):
    __slots__ = ("x", "y", "heading", "linear", "angular", "estimate_mean", "links")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    HEADING_FIELD_NUMBER: _ClassVar[int]
    LINEAR_FIELD_NUMBER: _ClassVar[int]
    ANGULAR_FIELD_NUMBER: _ClassVar[int]
    ESTIMATE_MEAN_FIELD_NUMBER: _ClassVar[int]
    LINKS_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    heading: float
    linear: float
    angular: float
    estimate_mean: float
    links: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., heading: _Optional[float] = ..., linear: _Optional[float] = ..., angular: _Optional[float] = ..., estimate_mean: _Optional[float] = ..., links: _Optional[float] = ...) -> None: ...

class LinkState(_message.Message):
    __slots__ = ("separation", "estimate_ij", "estimate_ji", "outage", "sent", "decoded", "longest_gap", "learnt_reception", "learnt_level", "learnt_exponent")
    SEPARATION_FIELD_NUMBER: _ClassVar[int]
    ESTIMATE_IJ_FIELD_NUMBER: _ClassVar[int]
    ESTIMATE_JI_FIELD_NUMBER: _ClassVar[int]
    OUTAGE_FIELD_NUMBER: _ClassVar[int]
    SENT_FIELD_NUMBER: _ClassVar[int]
    DECODED_FIELD_NUMBER: _ClassVar[int]
    LONGEST_GAP_FIELD_NUMBER: _ClassVar[int]
    LEARNT_RECEPTION_FIELD_NUMBER: _ClassVar[int]
    LEARNT_LEVEL_FIELD_NUMBER: _ClassVar[int]
    LEARNT_EXPONENT_FIELD_NUMBER: _ClassVar[int]
    separation: float
    estimate_ij: float
    estimate_ji: float
    outage: float
    sent: float
    decoded: float
    longest_gap: float
    learnt_reception: float
    learnt_level: float
    learnt_exponent: float
    def __init__(self, separation: _Optional[float] = ..., estimate_ij: _Optional[float] = ..., estimate_ji: _Optional[float] = ..., outage: _Optional[float] = ..., sent: _Optional[float] = ..., decoded: _Optional[float] = ..., longest_gap: _Optional[float] = ..., learnt_reception: _Optional[float] = ..., learnt_level: _Optional[float] = ..., learnt_exponent: _Optional[float] = ...) -> None: ...

class RobotStep(_message.Message):
    __slots__ = ("tick", "beacons", "number", "monotonic_ns", "observation", "beacon", "command", "fix")
    TICK_FIELD_NUMBER: _ClassVar[int]
    BEACONS_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    MONOTONIC_NS_FIELD_NUMBER: _ClassVar[int]
    OBSERVATION_FIELD_NUMBER: _ClassVar[int]
    BEACON_FIELD_NUMBER: _ClassVar[int]
    COMMAND_FIELD_NUMBER: _ClassVar[int]
    FIX_FIELD_NUMBER: _ClassVar[int]
    tick: int
    beacons: _containers.RepeatedScalarFieldContainer[bytes]
    number: int
    monotonic_ns: int
    observation: bytes
    beacon: bytes
    command: bytes
    fix: Fix
    def __init__(self, tick: _Optional[int] = ..., beacons: _Optional[_Iterable[bytes]] = ..., number: _Optional[int] = ..., monotonic_ns: _Optional[int] = ..., observation: _Optional[bytes] = ..., beacon: _Optional[bytes] = ..., command: _Optional[bytes] = ..., fix: _Optional[_Union[Fix, _Mapping]] = ...) -> None: ...

class Fix(_message.Message):
    __slots__ = ("stamp_ns", "x", "y", "heading")
    STAMP_NS_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    HEADING_FIELD_NUMBER: _ClassVar[int]
    stamp_ns: int
    x: float
    y: float
    heading: float
    def __init__(self, stamp_ns: _Optional[int] = ..., x: _Optional[float] = ..., y: _Optional[float] = ..., heading: _Optional[float] = ...) -> None: ...
