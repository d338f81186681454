"""The world on the bus.

server            observations out, commands in, tick after tick
lockstep          the barrier: each tick waits for all commands
live              the live clock: ticks wait for no robot
registry          queries and tokens of the agents
participation     changes of participation, logged
claim             one world per run on the network
command_gate      the only process that may command a robot
beacon_tap        the world's own copy of each beacon, by which it judges senders
report_publisher  the Report to observers, ten times per second
farewell          the end of a run, repeated until each agent has received it
access            Zenoh's access control: which role may publish and receive what
audit             log of rejected connections and messages
"""
