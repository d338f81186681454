"""The world: ground truth, the radio channel, and the barrier of a tick.

config      the scenario: tables, rules, events, expectations
simulation  one tick of the truth: bodies, contacts, channel
metrics     what a run achieved: errors, tracking, digest, report, summary
execution   one run, its log, its checkpoints, and resuming it
server      the world on the bus: registry, barrier, live clock, access
flags       the command line of fes-world
process     the shell: fes-world
__main__    entry point of fes-world
"""
