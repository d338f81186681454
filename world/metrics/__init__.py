"""What a run achieved.

collector       adds up every tick from truth and telemetry
link_errors     errors of links and estimates, and the times at which they fall
tracking        how fast and how well the optimum is found, after each change
period_average  separations averaged over a dither period
deadlines       how well robots keep the live clock's pace
optimum         r*, the separation that maximizes the index (16)
graphs          algebraic connectivity of a graph
digest          SHA-256 over all ticks
report_builder  the report to observers
summary         summary.json and scenario.toml of a run directory
"""
