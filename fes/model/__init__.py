"""The model: settings, sensing, and the objective.

config        AgentConfig: everything that an agent may know.
seeking       the settings of the seeking laws.
table         the tables of a configuration, and the choice of an extension.
sensing       what a crew senses, receives and publishes in one tick, as arrays.
contacts      the peers that a robot has heard, and the last beacon of each.
kinematics    the unicycle (5) on its arc, and the lag of its twists.
beacon_slots  beacons as samples of the channel: those that decoded, and those that were missed.
objective     the robots' own half of the performance index (16).
quantities    names, units and descriptions of the values in a summary.
outage        equations (3) and (4); of the agents only `agents.laws.oracle` may import it.
stability     rules between the tick and the gains.
counts        how often one setting fits into another.
"""
