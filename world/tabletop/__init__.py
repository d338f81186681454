"""A table with small robots: bodies and their vendor's drivers, and a radio that loses beacons as the channel does.

It stands in for hardware and knows the truth; robots learn from it only their own poses, and what their radios hear.

bodies           the interface of a team of bodies; scale
kinematic        bodies that follow their commands exactly
mujoco_model     the model of wheels, motors and floor, as MJCF
mujoco_bodies    bodies in MuJoCo
held_command     the rules by which a driver obeys
drivers          the vendor's drivers on the bus, in ROS 2 messages
reachability     reception probabilities at the true poses
relay            the fate of each datagram, and the counts
radio_socket     the socket of the relay
pacing           steps that are due in real time
truth_file       the truth, line by line, for tests and figures
process          the process fes-tabletop
"""
