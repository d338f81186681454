"""The world on the bus.

server         observations out, commands in, tick after tick
lockstep       the barrier: every tick waits for all commands
live           the live clock: ticks wait for no robot
registry       which agent hosts which robot, and its lease
participation  which robots take part in a tick
claim          one world per run on the network
command_gate   the one process that may command a robot
beacon_tap     the world's own copy of every beacon, by which it judges senders
farewell       the end of a run, repeated until it is heard
access         Zenoh's access control: who may publish and receive what
audit          log of rejected connections
"""
