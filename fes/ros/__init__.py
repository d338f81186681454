"""Bytes and keys of ROS 2, for robots whose drivers speak it: no ROS and no Zenoh is needed here.

cdr       numbers and texts in XCDR1, the encoding of ROS 2 over DDS and over Zenoh
messages  poses and twists from and to the payloads of five messages
types     full names and hashes of these messages
topics    keys and attachments of a topic, in the style of a bridge or of rmw_zenoh
graph     liveliness tokens: the publishers and subscribers that a ROS 2 graph shows
"""
