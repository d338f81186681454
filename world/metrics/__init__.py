"""Metrics of a run, from the truth and from the robots' telemetry.

collector        collects the metrics, tick by tick
tick_truth       one tick as the metrics see it
link_errors      errors of links and estimates, and when they fall below their levels
tracking         time and accuracy of seeking, after the start and each change
period_average   separations averaged over a dither period
deadlines        deadlines of the live clock, met and missed
best_separation  the best separation of a channel, by search where it has no formula
optimum          r*, the separation that maximizes the index (16)
graphs           connectivity of a graph, and the robots that cut it
digest           SHA-256 over all ticks
report_builder   the report to observers
summary          summary.json and scenario.toml of a run directory
team             metrics of the whole team's configuration
"""
