"""Messages, bytes and memory as robots, contacts and ticks increase.

growth      messages and bytes per tick at the router, from 10 to 100 robots
cost        CPU time of a world and of a separate router; the lockstep behind a delay
own_router  a small program that runs a router separate from the world
crowd       robots that all start in range of each other: memory and time per contact
memory      memory against the length of a run: python -m bench.size.memory, half an hour
"""
