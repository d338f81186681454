"""Many runs of a scenario: fes sweep.

command     the command, from its arguments to its files
design      the design of the experiment: axes, seeds, cells, runs and their keys
stack       several runs as one array program
work        what is handed to a worker, and what it hands back
local       workers on this machine
cluster     workers of a Dask cluster
ledger      what is done, kept through every interruption
table       one row a run, as CSV or Parquet
comparison  what the rows say: cells, and paired differences between them
report      the same as a person reads it
picture     the same as a figure
"""
