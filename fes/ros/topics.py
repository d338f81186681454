"""Keys and attachments of a ROS 2 topic over Zenoh, in two styles.

| style     | the robot's side                                    | key                          | attachment |
|-----------|-----------------------------------------------------|------------------------------|------------|
| ros2dds   | any ROS 2 over DDS, and zenoh-bridge-ros2dds        | the topic's name             | empty      |
| rmw_zenoh | ROS 2 with rmw_zenoh, Jazzy or later                | domain, name, type, hash     | 33 bytes   |

Sources: design.md of ros2/rmw_zenoh and its pull request 601 (the attachment); eclipse-zenoh/zenoh-plugin-ros2dds.
"""

import re
import struct
from typing import Literal, NamedTuple, get_args

from fes.errors import FesError
from fes.ros.types import TYPES

Style = Literal["ros2dds", "rmw_zenoh"]
STYLES: tuple[Style, ...] = get_args(Style)

GID_LENGTH = 16
"""Length of a publisher's identity [bytes]."""

LARGEST_DOMAIN = 232
"""Largest ROS_DOMAIN_ID that has ports of its own in DDS."""

LONGEST_NAME = 200
"""Longest name of a topic [characters]."""

_NAME = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_ATTACHMENT = struct.Struct(f"<qqB{GID_LENGTH}s")


class Topic(NamedTuple):
    """A topic of a robot."""

    style: Style
    name: str
    """Absolute name, such as /robot3/cmd_vel; the first slash may be absent."""
    type: str
    """Short name of its message, a key of TYPES."""
    domain: int = 0
    """ROS_DOMAIN_ID; the style ros2dds does not use it."""


class Attachment(NamedTuple):
    """The attachment of a sample in the style rmw_zenoh."""

    sequence: int
    """Number of the sample, from 1; each publisher counts its own."""
    time: int
    """Time of the sample on the publisher's clock [ns]."""
    gid: bytes
    """Identity of the publisher."""


def check_topic(topic: Topic) -> Topic:
    """`topic` itself, if it can be part of a key; raises FesError."""
    if topic.style not in STYLES:
        raise FesError(f"the style of a robot's keys is one of {', '.join(STYLES)}: {topic.style[:40]!r}")
    if len(topic.name) > LONGEST_NAME or not _NAME.fullmatch(topic.name):
        raise FesError(f"a topic's name has parts of letters, digits and _, divided by slashes: {topic.name[:40]!r}")
    if topic.type not in TYPES:
        raise FesError(f"a topic's type is one of {', '.join(TYPES)}: {topic.type[:40]!r}")
    if not 0 <= topic.domain <= LARGEST_DOMAIN:
        raise FesError(f"a domain of ROS is from 0 to {LARGEST_DOMAIN}: {topic.domain}")
    return topic


def publish_key(topic: Topic) -> str:
    """The key to publish a topic on; raises FesError for a topic that cannot have one.

    >>> publish_key(Topic("ros2dds", "/robot3/cmd_vel", "Twist"))
    'robot3/cmd_vel'
    """
    kind = TYPES[check_topic(topic).type]
    return _key(topic, kind.hash)


def subscribe_key(topic: Topic) -> str:
    """The key to subscribe to a topic on; raises FesError for a topic that cannot have one.

    Any hash is accepted: Humble writes none.

    >>> subscribe_key(Topic("rmw_zenoh", "/robot3/odom", "Odometry"))
    '0/robot3/odom/nav_msgs::msg::dds_::Odometry_/*'
    """
    check_topic(topic)
    return _key(topic, "*")


def attachment(topic: Topic, sequence: int, time_ns: int, gid: bytes) -> bytes:
    """The attachment of a sample: its number, from 1, its time [ns] and its publisher; empty in the style ros2dds."""
    if topic.style == "ros2dds":
        return b""
    if sequence < 1 or len(gid) != GID_LENGTH:  # older subscribers reject 0
        raise FesError(f"an attachment has a sequence from 1 and a gid of 16 bytes: {sequence}, {len(gid)} bytes")
    return _ATTACHMENT.pack(sequence, time_ns, GID_LENGTH, gid)


def read_attachment(data: bytes) -> Attachment | None:
    """The parts of an attachment in the style rmw_zenoh; None for other bytes, such as those of older versions."""
    if len(data) != _ATTACHMENT.size:
        return None
    sequence, time, length, gid = _ATTACHMENT.unpack(data)
    return Attachment(sequence, time, gid) if length == GID_LENGTH else None


def _key(topic: Topic, hash_: str) -> str:
    name = topic.name.removeprefix("/")
    return name if topic.style == "ros2dds" else f"{topic.domain}/{name}/{TYPES[topic.type].dds}/{hash_}"
