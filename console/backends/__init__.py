"""Execution of runs.

inprocess        one loop without Zenoh: world and robots together
stacked          many in-process runs as one array program
processes        processes over Zenoh: a world and its agents
announcement     the first lines of fes run
process_group    the processes of a run, none of which outlives fes run
managed_process  one child process: start, signals, outcome
view             views of a run with processes: dashboard, progress, reports
supervisor       the end of a process: its consequences for the run
restart_limits   limits on restarts of agents that died
fault_injection  scheduled deaths and hangs of real processes
"""
