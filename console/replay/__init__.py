"""Replay and comparison of logs.

command      the command fes replay
robot_logs   fes replay of the logs of real robots
robot_steps  a second execution of a real robot: compared with its log to the bit
log          logs of runs, with their scenarios
recorded     messages of a log, decoded and checked
reexecution  a second execution of the world of a log: compared with it to the bit
robots       a second execution of some of its robots
difference   differences between two ticks
compare      the command fes compare
player       the dashboard of a log: play, pause, step, seek
browser      the page of a recorded run in a browser
"""
