"""Keys and attachments, against those that others build."""

import pytest
from zenoh import KeyExpr
from zenoh.ext import Int64, z_serialize

from fes.errors import FesError
from fes.ros.topics import Attachment, Topic, attachment, publish_key, read_attachment, subscribe_key

COMMAND = Topic("rmw_zenoh", "/robot3/cmd_vel", "Twist")
POSE = Topic("rmw_zenoh", "/robot3/odom", "Odometry", 7)
GID = bytes(range(16))
HASH = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
OF_PAMOJA = f"0/robot3/cmd_vel/geometry_msgs::msg::dds_::Twist_/{HASH}"
"""`pamoja.ros2.entity_key(0, "/robot3/cmd_vel", "geometry_msgs/msg/Twist", HASH)` of pamoja-ros2 0.2.0."""


def test_the_key_of_rmw_zenoh_is_that_of_another_builder() -> None:
    assert publish_key(COMMAND) == OF_PAMOJA


def test_a_subscriber_of_rmw_zenoh_accepts_any_hash_in_its_own_domain_only() -> None:
    wanted = KeyExpr(subscribe_key(POSE))
    kind = "nav_msgs::msg::dds_::Odometry_"
    for hash_ in ("RIHS01_00", "TypeHashNotSupported"):
        assert wanted.intersects(KeyExpr(f"7/robot3/odom/{kind}/{hash_}"))
        assert not wanted.intersects(KeyExpr(f"0/robot3/odom/{kind}/{hash_}"))
        assert not wanted.intersects(KeyExpr(f"7/robot3/odom/geometry_msgs::msg::dds_::Twist_/{hash_}"))


def test_a_bridges_key_is_the_topics_name() -> None:
    topic = Topic("ros2dds", "/robot3/cmd_vel", "TwistStamped", 5)
    assert publish_key(topic) == subscribe_key(topic) == "robot3/cmd_vel"
    assert publish_key(topic._replace(name="robot3/cmd_vel")) == "robot3/cmd_vel"


def test_the_attachment_is_that_which_zenoh_itself_serializes() -> None:
    made = attachment(COMMAND, 1, 1_700_000_000_000_000_000, GID)
    assert made == z_serialize((Int64(1), Int64(1_700_000_000_000_000_000), GID)).to_bytes()
    assert len(made) == 33
    assert read_attachment(made) == Attachment(1, 1_700_000_000_000_000_000, GID)


def test_a_bridge_gets_no_attachment() -> None:
    assert attachment(COMMAND._replace(style="ros2dds"), 1, 2, GID) == b""


@pytest.mark.parametrize("data", [b"", bytes(33), bytes(32), bytes(34), b"\x0fsequence_number" + bytes(17)])
def test_an_attachment_of_another_format_is_none(data: bytes) -> None:
    assert read_attachment(data) is None


@pytest.mark.parametrize(("sequence", "gid"), [(0, GID), (-1, GID), (1, b""), (1, bytes(17))])
def test_an_attachment_that_others_would_refuse_is_not_made(sequence: int, gid: bytes) -> None:
    with pytest.raises(FesError, match="an attachment has"):
        attachment(COMMAND, sequence, 0, gid)


@pytest.mark.parametrize(
    "topic",
    [
        *(
            COMMAND._replace(name=name)
            for name in ("", "/", "a//b", "a/", "*", "a/**", "a$*", "3a", "~/a", "a b", "x" * 201)
        ),
        COMMAND._replace(type="Pose"),
        COMMAND._replace(domain=-1),
        COMMAND._replace(domain=233),
        COMMAND._replace(style="dds"),  # type: ignore[arg-type]
    ],
    ids=str,
)
def test_a_topic_that_cannot_have_a_key_is_refused_in_one_line(topic: Topic) -> None:
    for key in (publish_key, subscribe_key):
        with pytest.raises(FesError) as refused:
            key(topic)
        assert str(refused.value).isprintable()
        assert len(str(refused.value)) < 200
