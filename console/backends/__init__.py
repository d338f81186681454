"""How runs are executed.

inprocess        the same world and crew in one loop, without Zenoh
stacked          many in-process runs as one array program
processes        fes run with real processes
announcement     the first lines of fes run, before it starts anything
process_group    child processes, none of which outlives fes run
managed_process  one child process, and how it ended
supervisor       what the end of a child means for its run
restart_limits   limits on restarts of agents that died
fault_injection  scheduled deaths and hangs of real processes
"""
