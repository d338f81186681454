"""Schemes of one scenario file, compared: a row for each, a column for each outcome.

outcomes  means over the seeds, with intervals
report    the table, for a terminal and as Markdown
picture   the same as a figure
"""
