"""A table with small robots: bodies and their vendor's drivers, and a radio that loses beacons as the channel does.

It stands in for hardware and knows the truth; robots learn from it only their own poses, and what their radios hear.

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
