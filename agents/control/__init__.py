"""The control step of a crew, and the choice of its ticks: pure.

crew          crew.step, from what a crew senses and receives to twists and the next beacons.
state         a crew and its state.
contacts      the peers that a robot has heard, updated by the beacons of a tick.
links         the links that the neighbor rule selected.
localization  the pose of a robot: dead reckoning, corrected by fixes.
motion        the twists that follow a formation law's pull (6), (7).
separation    the filter that keeps robots apart.
ticks         the tick to answer next, in lockstep and with a live clock.
clocks        emulated clocks that drift.
transmitter   emulated transmitters that are faulty.
"""
