"""The control step of a crew, and the choice of its ticks: pure.

crew             crew.step, from observations and beacons to twists and the next beacons
state            a crew and its state.
seeking          each index with the law that climbs it.
contacts         the peers in range, updated by the beacons of a tick.
links            the links that the neighbor rule selected.
beacon_counting  beacons as samples of the packet reception ratio.
clocks           emulated clocks that drift.
ticks            the tick to answer next, in lockstep and with a live clock.
transmitter      emulated transmitters that are faulty.
"""
