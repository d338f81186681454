"""The senses of a robot without a world: an Observation per tick from the beacons that its radio has heard. Pure.

senses       Senses: the observation and the beacons of each tick.
slots        the slots of one peer: the own tick of each of its beacons, and the beacons that wait for it.
steering     when a peer's offset must follow the drift of two clocks.
slot_counts  counts per peer.
own_poses    own poses of the last ticks, at any time between them.
"""
