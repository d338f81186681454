"""The log of a real robot, robot-3.mcap: what its code received and returned. See docs/reference/log.md.

layout    number of the format, header, and names of files and topics
topics    the messages of the file, with those for viewers
recorder  the robot's side: hands each step to the writer, and never waits for it
reader    a log with its header, steps and events
"""
