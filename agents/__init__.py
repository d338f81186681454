"""One robot a process, or a crew of them: from observations and beacons to beacons and commands.

process     the shell: fes-agent joins, waits for a tick, publishes
assembly    messages into a crew's arrays, and back
crew        pure: the table of contents of a robot
contacts    who is heard, and where
neighbors   graph rules, and the weights (9)
formation   the formation law (6), (7)
seeking     the seeking law (18), printed and corrected
oracle      the paper's shortcut (33): being told the channel
"""
