"""Shapes of a team of n robots, in units of the link length, and what they say about that length.

choice  the shape that a configuration asks for
shape   a shape: its slots and links, and how much link quality weighs against coverage
patch   the best patch of the triangular lattice
drawn   shapes that a mission may ask for: line, ring, ladder
rules   settings with which a configuration cannot work
routes  least costs of routes over relays, also without each single robot
"""
