"""A robot in the real world: its body, its gate, its radio and its senses instead of a simulated world.

radio   authenticated beacons by UDP.
senses  an Observation per tick from the beacons heard.
"""
