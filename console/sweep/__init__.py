"""fes sweep: many runs of a scenario.

command     the command: from its arguments to its files
design      design of the experiment: axes, seeds, cells, runs and their keys
work        batches for workers, and their results
local       workers on this machine
cluster     workers of a Dask cluster
ledger      finished runs: durable through interruptions
table       table of runs: one row per run, as CSV or Parquet
comparison  cells, and paired differences between them
results     rows, cells and differences, and the files that hold them
report      the comparison as a table
picture     the comparison as a figure
schemes     schemes of one file, compared: their table and figure
"""
