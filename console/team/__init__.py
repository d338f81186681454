"""The commands fes team: a person's side of a team of real robots.

merge      the latest RobotReports of the robots, as one Report
observer   an observer on the bus: merged Reports at 10 Hz
recorder   the log and the summary of what an observer saw
gates      queries to the gates of the robots, repeated until each has answered
permit     the operator's Permits, and a team that is held by them
router     fes team router: the network between operators and gates
status     the table of fes team status
robot_tables   robot.toml of a team on a table, from its scenario
table_run      fes team run: a team on a table, with all processes of real robots
table_result   its result: the reports beside the truth
table_command  the command fes team run
command    fes team status, start, stop, permit, view and router
"""
