"""The dashboard: functions from reports to frames, and the printed summary.

command         fes view
live            draws frames from reports
history         the reports so far: errors over time, paths of robots, extent of the team
frame           one frame: all panels, from the reports so far
layout          widths and heights of the panels, by the proportions of the team and their importance
header          lines at the top: progress, source of the index, rates, team
canvas          braille dots
summary         the summary for a terminal: at most 20 lines, the headline last
summary_tables  the tables of a verbose summary
summary_words   numbers, verdicts and the headline of a summary in words
panels          the panels: map, convergence, links, connectivity, team, reception, legend
"""
