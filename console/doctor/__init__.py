"""What may keep a run from starting, or from being seen: fes doctor.

command     the command, and its table
finding     one check and what it saw
installation  our packages, and other packages that have their names
machine     Python, packages, files, clock, the loopback interface
network     who listens, who is alive, and what the world says of itself
"""
