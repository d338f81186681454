"""Metrics of the whole team's configuration.

coverage         area that the robots cover
delivery         delivery between all robots, also after the worst loss of one
at_the_end       both as metrics of the last tick
link_index       metric: mean of the index J over the links
links_connected  metric: connection of the team by its links
travel           metric: distance that the robots travel
"""
