"""The command fes.

cli        the commands of fes
guide      their order in the help, with an example of each
api        the Python interface: load, run, read and sweep, as the package fes offers them
backends   how runs are executed: processes, one loop, stacked
connect    run directories, reports of a running world, and fes set
measures   numbers of a report that every view shows
dashboard  the live dashboard: reports to frames
foxglove   a running run in Foxglove and Lichtblick
web        the page of a run in a browser
terminal   lines, tables, progress, full-screen frames, keys pressed
replay     logs: fes replay and fes compare
sweep      fes sweep: many runs, compared
fit        fes fit: a channel from measurements
analysis   fes plot and fes claims: figures and studies
check      fes check: a check that an extension keeps the rules
doctor     fes doctor: checks of this machine and of a running run
keys       fes keys: certificates
team       fes team: real robots watched, started and stopped
schema     fes schema: the JSON schema of a scenario
__main__   entry point of fes
"""
