"""The commands that a person runs: fes run, view, set, replay, compare, sweep, plot, schema, doctor, keys, claims.

__main__    entry point of fes
cli         the commands
guide       their order in the help, and an example of each
announcement  the first lines of fes run, before it starts anything
processes   fes run with real processes
launcher    child processes, never left behind
child       one of them, and the report of its end
supervision the consequences of a child's end for its run
respawn     limits on restarts of agents that died
faults      scheduled deaths and hangs, for real
inprocess   the same world and crew in one loop, without Zenoh
history     a run as time series
figures     the paper's figures, and those of a run
claims      where the paper's text does not hold, as computations
learning    how robots that count beacons find the optimum, over seeds
study       how the integration error depends on the step
options     flags that several commands share
setting     the command fes set
schema      the command fes schema
evidence    the commands fes plot and fes claims
keyring     fes keys: certificates in a directory, or of one run
authority   certificates themselves
rundir      run directories
leftovers   private keys of runs that were killed
replay      the command fes replay
log         logs of runs, with their scenarios
reexecution a log executed again, and compared to the bit
difference  where two ticks differ
compare     the command fes compare
player      the dashboard of a log: play, pause, step, seek
keyboard    keys of a terminal
doctor      fes doctor: what may keep a run from starting
sweep       fes sweep: many runs, compared
summary     the summary as a person reads it
observer    the world's reports, as they come
view        the live dashboard
screen      full-screen frames: the only user of rich's Live
printing    lines and tables, in which data is never markup
progress    bars of commands that take longer than a second
dashboard   one frame, from the reports so far
header      its first lines
teammap     its map
panels      its convergence and connectivity
links       its table of links
reception   its chart of what measuring robots learn
canvas      braille dots
text        numbers as people read them
"""
