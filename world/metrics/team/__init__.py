"""Metrics of the whole team's configuration.

coverage         area that the robots cover
delivery         delivery between all robots, also after the worst loss of one
at_the_end       both as metrics of the last tick
team_index       the team index F: coverage and delivery in one number
target           F of the shape that the team takes up, at its best link length
progress         the team index of a run against its target
link_index       metric: mean of the index J over the links
links_connected  metric: connection of the team by its links
travel           metric: distance that the robots travel
"""
