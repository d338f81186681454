"""Messages, their encoding and their keys.

keys            every key expression, in one table
wire            fields of a payload, packed and checked
messages        Welcome, Observation, Beacon and Command
packing         payloads of the messages of each tick, from bytes
report          Report: the state of the team, for observers
robot_report    RobotReport: the state of one real robot, for observers
robot_control   operator and gates of real robots: permit and state
older           payloads of logs of protocol 3
world_info      the world's description of itself
sealed          the authenticated datagram of a beacon between real robots
channel_change  a request to change the channel, and its result
"""
