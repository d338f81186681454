"""The control step of a crew: pure.

crew             crew.step: from observations and beacons to twists and the next beacons
contacts         update of the contacts by the beacons of a tick
links            the links that the graph rule selected
beacon_counting  beacons as samples of the packet reception ratio
clocks           emulated clocks that drift
transmitter      emulated transmitters that are faulty
"""
