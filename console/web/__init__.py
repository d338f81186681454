"""The page of a run in a browser, served by Bokeh on the loopback interface.

command     flags of fes view --web, and the serving of a page
feed        reports of a running run, for all pages
history     curves and paths of the run so far
columns     a report as columns of numbers
facts       the header: facts about the run, and its state
page        one browser: layout of the panels, and their update
team_map    map of the team with paths and links
charts      convergence, team index, reception
link_table  table of the links
controls    change of the channel
slider      time of a recorded run
server      Bokeh server: address, origins, frames
"""
