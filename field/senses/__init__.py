"""The senses of a robot without a world: an Observation per tick from the beacons that its radio has heard. Pure.

senses         Senses: the observation and the beacons of each tick.
peer           one peer: its newest beacon, and the verdict of each tick.
verdicts       Verdicts: which of a peer's beacons decoded, by their sequence numbers.
beacon_counts  counts per peer.
own_poses      own poses of the last ticks, at any time between them.
"""
