"""Arrays and geometry that both sides share.

types     type aliases for the arrays in signatures
edges     directed pairs (robot, peer) of a crew, and sums over them in a fixed order
geometry  angle wrapping, separation, line of sight
masks     whether all robots take part
"""
