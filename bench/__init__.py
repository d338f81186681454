"""Benchmarks: ratios and costs measured side by side in one run, printed beside their budgets.

against  the table of budgets: ratios to an earlier commit, to VMAS and to bare messages
speed    rates and times: the lockstep, one robot's step, the log, the start
size     messages, bytes and memory as robots, contacts and ticks increase
science  results over many seeds
"""
