"""The world: ground truth, the radio channel, and the barrier of a tick.

config      the scenario: tables, rules, events, expectations
simulation  one tick of the truth: bodies, contacts, channel
metrics     measures of a run: link errors, tracking, digest, report, summary
execution   one run: its state, log and checkpoints, and its resumption
tabletop    a table with small robots, without hardware: bodies, drivers, a lossy radio
server      the world on the bus: registry, barrier, live clock, access
flags       the command line of fes-world
process     the process fes-world: startup, main loop, shutdown
__main__    entry point of fes-world
"""
