"""Logs, replayed and compared.

command      the command fes replay
log          logs of runs, with their scenarios
reexecution  a log executed again, and compared to the bit
difference   where two ticks differ
compare      the command fes compare
player       the dashboard of a log: play, pause, step, seek
"""
