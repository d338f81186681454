"""The Python interface, which the package `fes` offers: load, run, read and sweep.

scenarios  load: a scenario from a file, a name or overrides
execution  run and read: a scenario or a log to a Run
sweeping   sweep: many runs to a table
result     a Run: arrays over ticks, and the table of links
sweep_table  the tables of a sweep
collector  the arrays of a run, tick by tick
columns    columns of values as arrays and data frames
background   a long call in a thread of its own, which its caller can interrupt
display    progress in a terminal or a notebook
arguments  errors in the words of the Python interface
"""
