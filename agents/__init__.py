"""One robot a process, or a crew of them: from observations and beacons to beacons and commands.

__main__    entry point of fes-agent
process     the shell: fes-agent joins, waits for a tick, publishes
assembly    messages into a crew's arrays, and back
radio       the beacons of the peers in range, and of no others
turns       when the next step is taken
membership  joining a run, and confirming that the robots are still the agent's
presence    whether the world is there
mouth       beacons and commands, and either again when it is asked for
crew        pure: the table of contents of a robot
contacts    who is heard, and where
neighbors   graph rules (2)
links       the links in use, and what is sought on each
transmitter what goes on the air, late or damaged if it is faulty
formation   the formation law (6), (7) and its weights (9)
counting    which beacons decoded and which were missed, and at which separations
reception   measured reception: the channel learnt from what was counted
seeking     the seeking law (18), printed and corrected
clocks      robots' own clocks, and how far they are off
collocation one step of (18): filters exactly, the index at a few times at once
oracle      the paper's shortcut (33): being told the channel
"""
