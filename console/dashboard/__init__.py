"""The dashboard: functions from reports to frames.

live             fes view: reports in, frames out
frame            one frame, from the reports so far
header           its first lines
map_panel        its map of the team
panels           its panels of convergence and connectivity
links_panel      its table of links
reception_panel  its chart of what measuring robots learn
canvas           braille dots
summary          the summary as a person reads it
"""
