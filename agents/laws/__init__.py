"""The laws: pure functions of arrays.

neighbor_rules   neighbor rules: the contacts that become links.
formation        distance-based formation control (6), (7), (9).
perturbation     extremum seeking by perturbation, with consensus (18).
collocation      solution of the linear filters over one step.
packet_counting  packet reception ratio, and the optimum it implies.
oracle           the performance index computed from the channel, for robots that know it.
draws            random numbers for robots and links.
"""
