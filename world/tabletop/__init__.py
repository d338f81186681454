"""A table with small robots in place of hardware. It knows the truth, of which robots learn only their own poses.

bodies        bodies: exact ones, and those of MuJoCo
held_command  the rules by which a driver obeys
drivers       the vendor's drivers on the bus, in ROS 2 messages
radio         the relay of datagrams: probabilities, counts, socket
pacing        steps that are due in real time
truth_file    the truth, line by line, for tests and figures
flags         the command line of fes-tabletop
process       the process fes-tabletop
__main__      entry point of fes-tabletop
"""
