"""Benchmarks: ratios and costs measured side by side in one run, beside their budgets.

bare        the lockstep's message pattern on bare Zenoh, computing nothing: what the wire alone costs
lockstep    fes against bare, in turn
robot       what one robot's process computes in a tick, and what the world's does
compute     crew.step, in-process rates, cost per robot-tick from 10 to 10,000 robots
recording   the lockstep with and without a log, in turn; bytes a robot-tick
secure      what TLS, access control and the audit cost, plain and secure runs in turn
memory      whether it grows with the length of a run: python -m bench.memory, half an hour
growth      messages and bytes a tick at the router, from 10 to 100 robots
cost        CPU time of a world and of a router of its own; the lockstep behind a delay
own_router  that router, as a small program
crowd       robots that all start in range of each other: memory and time per contact
startup     time and memory until an agent is ready
"""
