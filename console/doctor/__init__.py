"""fes doctor: checks of this machine and of a running run.

command       the command fes doctor, and its table
core          the compiled core: its libraries, and the reason where numpy computes instead
finding       the result of one check
installation  our packages: conflicts with other projects
machine       Python, packages, arithmetic, files, clock, the loopback interface
network       ports, liveliness tokens, and the world's description of itself
"""
