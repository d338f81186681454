"""The dashboard: functions from reports to frames.

command          fes view
live             draws frames from reports
frame            one frame: all panels, from the reports so far
header           lines at the top: progress, rates, team
map_panel        map of the team
panels           convergence and connectivity
links_panel      table of links
team_panel       the team index, the robots that cut the links, and plans
reception_panel  chart: reception as measuring robots learn it
canvas           braille dots
summary          the summary as tables for a terminal
"""
