"""The laws: pure functions of arrays.

neighbor_rules        neighbor rules: the contacts that become links.
formation             distance-based formation control (9).
goals                 a goal of its own for each robot.
seeking_perturbation  seeking laws that climb an index by perturbation: with samples of J, and the base of the oracle.
seeking_measured      seeking laws that climb the slope of ln J measured by counting beacons.
learners              the learners of the channel: one per robot, or one per link end.
oracle                the seeking law of robots that know the channel, with the index of its formula.
link_estimates        the first estimates of links, and their dither.
perturbation          extremum seeking by perturbation, with consensus (18).
collocation           solution of the linear filters over one step.
packet_counting       packet reception ratio, and the optimum it implies.
core                  the compiled index of the oracle.
"""
