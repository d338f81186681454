"""Rates and times.

bare       the lockstep's message pattern on bare Zenoh, without computation: the cost of the wire
lockstep   rates of fes and of bare, measured alternately
robot      one tick of a robot's process and of the world's: time of each part
compute    crew.step, in-process rates, cost per robot-tick from 10 to 10,000 robots
recording  the lockstep with and without a log: rates, bytes per robot-tick
secure     cost of TLS, access control and the audit
startup    time and memory until an agent is ready
imports    the same of its imports, by package
functions  cost of the elementary functions, as ratios to numpy's own
"""
