"""Ratios to an earlier version and to VMAS, to bare messages, and of fes to itself: one table of budgets.

budgets       the rows: programs, and wanted ratios
choice        rows and details by the names on the command line
commands      fes with a core: programs, the sweep, the lockstep, the start of agents
cores         the values of FES_CORE, and the core that each selects
environments  the tree and the virtual environment of an earlier commit, and that of VMAS
old           programs of the earlier commit
ours          programs of this tree, one core each
plan          the circumstances of a table, and what a row is
programs      numbers that programs print, and the processor time of commands
rounds        both sides of a ratio in turn
table         the Markdown table
vmas          VMAS's flocking, one thread
"""
