"""Full names and hashes of the ROS 2 messages that a robot speaks.

The hashes are those of REP 2016 (RIHS01). The definitions, and so the hashes, are the same from Humble to Kilted.
"""

from typing import NamedTuple


class MessageType(NamedTuple):
    """A message of ROS 2."""

    package: str
    name: str
    hash: str

    @property
    def full(self) -> str:
        """Its name in ROS 2.

        >>> TYPES["Odometry"].full
        'nav_msgs/msg/Odometry'
        """
        return f"{self.package}/msg/{self.name}"

    @property
    def dds(self) -> str:
        """Its name in DDS, which is a part of keys too.

        >>> TYPES["Odometry"].dds
        'nav_msgs::msg::dds_::Odometry_'
        """
        return f"{self.package}::msg::dds_::{self.name}_"


TYPES = {
    kind.name: kind
    for kind in (
        MessageType(
            "geometry_msgs", "Twist", "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
        ),
        MessageType(
            "geometry_msgs", "TwistStamped", "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"
        ),
        MessageType(
            "nav_msgs", "Odometry", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"
        ),
        MessageType(
            "geometry_msgs", "PoseStamped", "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"
        ),
        MessageType(
            "geometry_msgs",
            "PoseWithCovarianceStamped",
            "RIHS01_26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e",
        ),
        MessageType("std_msgs", "Bool", "RIHS01_feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9"),
    )
}
"""Each message by its short name."""

BY_FULL_NAME = {form: kind.name for kind in TYPES.values() for form in (kind.full, kind.dds)}
"""The short name of a message, by its name in ROS 2 and by that in DDS."""
