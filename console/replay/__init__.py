"""Replay and comparison of logs.

command      the command fes replay
log          logs of runs, with their scenarios
reexecution  a second execution of a log: compared with it to the bit
difference   differences between two ticks
compare      the command fes compare
player       the dashboard of a log: play, pause, step, seek
"""
