"""Liveliness tokens: the publishers and subscribers that a ROS 2 graph shows.

Delivery needs no tokens. `ros2 topic list` and `fes doctor` need them: they tell who publishes a topic, and the type.

| style     | token                                                                                              |
|-----------|----------------------------------------------------------------------------------------------------|
| rmw_zenoh | @ros2_lv/domain/session/node id/id/kind/enclave/namespace/node, then /topic/type/hash/QoS          |
| ros2dds   | @/session of the bridge/@ros2_lv/kind/topic/type/QoS; bridges declare them, and nothing else does  |

A slash inside a part is written % or §, and an empty part %. Sources: design.md of ros2/rmw_zenoh;
liveliness_mgt.rs of eclipse-zenoh/zenoh-plugin-ros2dds.
"""

from collections.abc import Sequence
from typing import NamedTuple

from fes.ros.topics import Style, Topic, check_topic
from fes.ros.types import BY_FULL_NAME, TYPES

NODE, PUBLISHER, SUBSCRIBER = "NN", "MP", "MS"
KINDS = (NODE, PUBLISHER, SUBSCRIBER, "SS", "SC")
"""Kinds of an endpoint: node, publisher, subscriber, server and client of a service."""

LONGEST_TOKEN = 1024
"""Longest token that is read [characters]."""

DEFAULT_DEPTH = 42
"""Depth of a history that rmw_zenoh writes as an empty part."""

_SPACE = "@ros2_lv"
_BEST_EFFORT = "2"
_OF_NODE, _OF_TOPIC, _OF_BRIDGE = 9, 13, 7
"""Numbers of parts of a token."""


class Node(NamedTuple):
    """A node of ROS 2 that this process plays."""

    session: str
    """Id of its Zenoh session, in hexadecimal."""
    name: str
    namespace: str = ""
    """Such as /robot3; empty for the root."""
    domain: int = 0


class Qos(NamedTuple):
    """Quality of service, as far as a token tells it: volatile, and the last samples only."""

    reliable: bool
    depth: int = DEFAULT_DEPTH

    @property
    def part(self) -> str:
        """The part of a token; empty where rmw_zenoh has a default.

        >>> Qos(reliable=True, depth=10).part, Qos(reliable=False).part
        ('::,10:,:,:,,', '2::,:,:,:,,')
        """
        depth = "" if self.depth == DEFAULT_DEPTH else self.depth
        return f"{'' if self.reliable else _BEST_EFFORT}::,{depth}:,:,:,,"


OWN_QOS = Qos(reliable=False, depth=1)
"""The truth about `fes.transport.foreign`: a sample that the network cannot take is dropped, and none waits."""


class Endpoint(NamedTuple):
    """A node, a publisher or a subscriber of the graph."""

    style: Style
    kind: str
    session: str
    """Id of the Zenoh session: of the node, or of the bridge."""
    domain: int
    """0 for a bridge, whose tokens do not tell it."""
    node: str
    """Full name, such as /robot3/driver; empty for a bridge."""
    topic: str = ""
    """Absolute name; empty for a node."""
    type: str = ""
    """Short name of the message if it is one of TYPES, otherwise the name that the token has."""
    hash: str = ""
    reliable: bool = True


def tokens(node: Node, published: Sequence[Topic], subscribed: Sequence[Topic]) -> tuple[str, ...]:
    """All tokens of a node for its topics in the style rmw_zenoh; empty without such topics.

    Raises FesError for a topic that cannot have a key.
    """
    ends = [(PUBLISHER, topic) for topic in published] + [(SUBSCRIBER, topic) for topic in subscribed]
    ends = [(kind, topic) for kind, topic in ends if check_topic(topic).style == "rmw_zenoh"]
    if not ends:
        return ()
    own = [_topic_token(node, kind, topic, id_) for id_, (kind, topic) in enumerate(ends, start=1)]
    return (node_token(node), *own)


def node_token(node: Node) -> str:
    """The token of a node, whose id is 0."""
    return _node_part(node, 0, NODE)


def publisher_token(node: Node, topic: Topic, id_: int) -> str:
    """The token of a publisher of the node, with an id of its own; raises FesError."""
    return _topic_token(node, PUBLISHER, check_topic(topic), id_)


def subscriber_token(node: Node, topic: Topic, id_: int) -> str:
    """The token of a subscriber of the node, with an id of its own; raises FesError."""
    return _topic_token(node, SUBSCRIBER, check_topic(topic), id_)


def publishers(topic: Topic) -> str:
    """A pattern of the tokens of all publishers of a topic, of any type; raises FesError."""
    return _pattern(PUBLISHER, check_topic(topic))


def subscribers(topic: Topic) -> str:
    """A pattern of the tokens of all subscribers to a topic, of any type; raises FesError."""
    return _pattern(SUBSCRIBER, check_topic(topic))


def parse_token(key: str) -> Endpoint | None:
    """The endpoint of a token of either style; None for any other key."""
    parts = key.split("/") if len(key) <= LONGEST_TOKEN else []
    if len(parts) == _OF_BRIDGE and parts[0] == "@" and parts[2] == _SPACE and parts[3] in (PUBLISHER, SUBSCRIBER):
        return _of_bridge(*parts[3:], session=parts[1])
    if len(parts) not in (_OF_NODE, _OF_TOPIC) or parts[0] != _SPACE or parts[5] not in KINDS:
        return None
    domain, kind = parts[1], parts[5]
    is_number = domain.isascii() and domain.isdecimal() and len(domain) <= 3
    if not is_number or (kind == NODE) != (len(parts) == _OF_NODE):
        return None
    namespace, name = _plain(parts[7]), _plain(parts[8])
    node = f"{namespace.rstrip('/')}/{name}"
    endpoint = Endpoint("rmw_zenoh", kind, parts[2], int(domain), node)
    if kind == NODE:
        return endpoint
    topic, type_, hash_, qos = parts[9:]
    reliable = not qos.startswith(f"{_BEST_EFFORT}:")
    return endpoint._replace(topic=_plain(topic), type=_short(type_), hash=hash_, reliable=reliable)


def _of_bridge(kind: str, topic: str, type_: str, qos: str, *, session: str) -> Endpoint:
    name = "/" + topic.replace("§", "/")
    stated = qos.split(":")[1:2]  # 0 or 1 of DDS; nothing for its default: only writers are reliable
    reliable = stated == ["1"] or (stated in ([], [""]) and kind == PUBLISHER)
    return Endpoint("ros2dds", kind, session, 0, "", name, _short(type_.replace("§", "/")), reliable=reliable)


def _node_part(node: Node, id_: int, kind: str) -> str:
    place = _mangled(node.namespace) or "%"
    return f"{_SPACE}/{node.domain}/{node.session}/0/{id_}/{kind}/%/{place}/{_mangled(node.name)}"


def _topic_token(node: Node, kind: str, topic: Topic, id_: int) -> str:
    message = TYPES[topic.type]
    name = _mangled("/" + topic.name.removeprefix("/"))
    return f"{_node_part(node, id_, kind)}/{name}/{message.dds}/{message.hash}/{OWN_QOS.part}"


def _pattern(kind: str, topic: Topic) -> str:
    name = topic.name.removeprefix("/")
    if topic.style == "ros2dds":
        return f"@/*/{_SPACE}/{kind}/{name.replace('/', '§')}/*/*"
    return f"{_SPACE}/{topic.domain}/*/*/*/{kind}/*/*/*/{_mangled('/' + name)}/*/*/*"


def _mangled(name: str) -> str:
    return name.replace("/", "%")


def _plain(part: str) -> str:
    return part.replace("%", "/")


def _short(type_: str) -> str:
    return BY_FULL_NAME.get(type_, type_)
