"""The panels of the dashboard: functions from reports to lines of styled text.

map_panel        map of the team
convergence      errors over time, and the tracking of r*
reception_panel  chart: reception as measuring robots learn it
links_panel      table of links
connectivity     components of the links and of the disk graph, and absent robots
team_panel       the team index, the robots that cut the links, and plans
legend           the words on the screen in a few more words
"""
