"""The model: settings, sensing, and the objective.

config     AgentConfig: everything that an agent may know
sensing    what a crew senses and publishes in one tick, as arrays
contacts   the peers in range, and the last beacon of each
objective  the robots' own half of the performance index (16)
quantities names, units and descriptions of the values in a summary
outage     equations (3) and (4); of the agents only `agents.laws.oracle` may import it
stability  rules between the tick and the gains
counts     how often one setting fits into another
"""
