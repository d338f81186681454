"""fes doctor: what may keep a run from starting, or from being seen.

command       the command, and its table
finding       one check and its result
installation  our packages, and other packages that have their names
machine       Python, packages, files, clock, the loopback interface
network       ports, tokens, and the world's description of itself
"""
