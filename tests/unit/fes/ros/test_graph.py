"""Tokens of the ROS 2 graph, against those in the documents and sources of others."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from zenoh import KeyExpr

from fes.errors import FesError
from fes.ros import graph
from fes.ros.graph import Endpoint, Node, Qos, parse_token
from fes.ros.topics import Topic
from fes.ros.types import TYPES
from tests.support.examples import EXAMPLES

COMMAND = Topic("rmw_zenoh", "/robot3/cmd_vel", "Twist")
POSE = Topic("rmw_zenoh", "/robot3/odom", "Odometry")
AGENT = Node("8b20917502ee955ac4476e0266340d5c", "fes_agent", "/robot3")
HASH = TYPES["Twist"].hash
STRING = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"

LISTENER = "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener"
TALKER = (
    "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/"
    f"std_msgs::msg::dds_::String_/{STRING}/::,7:,:,:,,"
)
"""Both from design.md of ros2/rmw_zenoh."""

SDK = (
    "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/0/MP/%/%robot3/fes_agent/%robot3%cmd_vel/"
    f"geometry_msgs::msg::dds_::Twist_/{HASH}/::,10:,:,:,,"
)
"""Seen from zenoh-ros2-sdk 0.1.8, a publisher of another author."""

BRIDGE = "@/3f2a/@ros2_lv/MP/robot3§odom/nav_msgs§msg§Odometry/:1:2:0,10"
"""After liveliness_mgt.rs of zenoh-plugin-ros2dds."""


def test_the_tokens_of_others_are_read() -> None:
    assert parse_token(LISTENER) == Endpoint("rmw_zenoh", "NN", LISTENER.split("/")[2], 0, "/listener")
    assert parse_token(TALKER) == Endpoint(
        "rmw_zenoh", "MP", TALKER.split("/")[2], 0, "/talker", "/chatter", "std_msgs::msg::dds_::String_", STRING
    )
    assert parse_token(SDK) == Endpoint(
        "rmw_zenoh", "MP", AGENT.session, 0, "/robot3/fes_agent", "/robot3/cmd_vel", "Twist", HASH
    )
    assert parse_token(BRIDGE) == Endpoint("ros2dds", "MP", "3f2a", 0, "", "/robot3/odom", "Odometry")


@pytest.mark.parametrize(
    ("kind", "qos", "reliable"),
    [("MP", ":0::", False), ("MS", ":0::", False), ("MP", "K:1::", True), ("MP", ":::", True), ("MS", ":::", False)],
)
def test_a_bridges_reliability_is_that_of_dds_with_its_defaults(kind: str, qos: str, reliable: bool) -> None:
    endpoint = parse_token(f"@/3f2a/@ros2_lv/{kind}/odom/nav_msgs§msg§Odometry/{qos}")
    assert endpoint is not None
    assert endpoint.reliable == reliable


def test_a_node_has_the_token_of_the_document() -> None:
    assert graph.node_token(Node("aac3178e146ba6f1fc6e6a4085e77f21", "listener")) == LISTENER


def test_a_publisher_has_the_token_of_the_sdk_except_for_its_quality_of_service() -> None:
    own, foreign = graph.publisher_token(AGENT, COMMAND, 0).split("/"), SDK.split("/")
    assert own[:-1] == foreign[:-1]
    assert own[-1] == "2::,1:,:,:,,"  # best effort, the last sample only
    assert foreign[-1] == Qos(reliable=True, depth=10).part


def test_the_tokens_of_a_process_are_its_node_and_each_topic_with_an_id_of_its_own() -> None:
    made = graph.tokens(AGENT, [COMMAND], [POSE])
    ends = [parse_token(token) for token in made]
    assert [end and (end.kind, end.topic, end.type, end.reliable) for end in ends] == [
        ("NN", "", "", True),
        ("MP", "/robot3/cmd_vel", "Twist", False),
        ("MS", "/robot3/odom", "Odometry", False),
    ]
    assert {end and end.node for end in ends} == {"/robot3/fes_agent"}
    assert len({token.split("/")[4] for token in made}) == 3
    assert made[1:] == (graph.publisher_token(AGENT, COMMAND, 1), graph.subscriber_token(AGENT, POSE, 2))


def test_a_bridges_topics_have_no_tokens_of_ours() -> None:
    assert graph.tokens(AGENT, [COMMAND._replace(style="ros2dds")], []) == ()


def test_a_pattern_matches_the_tokens_of_its_topic_and_kind_only() -> None:
    wanted = KeyExpr(graph.publishers(COMMAND))
    tokens = (SDK, graph.publisher_token(AGENT, COMMAND, 1), SDK.replace("Twist_", "TwistStamped_"))
    assert all(wanted.includes(KeyExpr(token)) for token in tokens)
    others = (
        TALKER,
        LISTENER,
        SDK.replace("MP", "MS"),
        SDK.replace("lv/0", "lv/1"),
        SDK.replace("%robot3%cmd_vel", "%robot33%cmd_vel"),
        graph.subscriber_token(AGENT, COMMAND, 1),
    )
    assert not any(wanted.intersects(KeyExpr(token)) for token in others)
    assert KeyExpr(graph.subscribers(COMMAND)).includes(KeyExpr(graph.subscriber_token(AGENT, COMMAND, 1)))


def test_a_pattern_of_a_bridge_matches_its_tokens_only() -> None:
    pose = POSE._replace(style="ros2dds")
    assert KeyExpr(graph.publishers(pose)).includes(KeyExpr(BRIDGE))
    assert not KeyExpr(graph.subscribers(pose)).intersects(KeyExpr(BRIDGE))
    assert KeyExpr(graph.subscribers(pose)).includes(KeyExpr(BRIDGE.replace("MP", "MS")))
    assert not KeyExpr(graph.publishers(POSE)).intersects(KeyExpr(BRIDGE))


@pytest.mark.parametrize(
    "key",
    [
        "",
        "robot3/odom",
        "@ros2_lv",
        LISTENER + "/x",
        LISTENER.replace("NN", "MP"),
        TALKER.replace("MP", "NN"),
        TALKER.replace("MP", "XX"),
        TALKER.replace("lv/0", "lv/x"),
        TALKER.replace("lv/0", "lv/٣"),
        TALKER + "x" * 2000,
        BRIDGE.replace("MP", "SS"),
        BRIDGE + "/x",
    ],
)
def test_another_key_is_refused_as_a_token(key: str) -> None:
    assert parse_token(key) is None


@settings(max_examples=3 * EXAMPLES)
@given(parts=st.lists(st.sampled_from([*TALKER.split("/"), *BRIDGE.split("/")]) | st.text(max_size=9), max_size=14))
def test_any_key_is_a_token_or_none(parts: list[str]) -> None:
    endpoint = parse_token("/".join(parts))
    assert endpoint is None or endpoint.kind in graph.KINDS


def test_a_topic_that_cannot_have_a_key_has_no_token() -> None:
    bad = COMMAND._replace(name="/robot3/*")
    for make in (graph.publishers, graph.subscribers, lambda topic: graph.tokens(AGENT, [topic], [])):
        with pytest.raises(FesError, match="a topic's name"):
            make(bad)
