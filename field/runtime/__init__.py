"""A real robot's own time: its ticks, its fixes, its steps and its reports.

tick_clock  ticks of the wall clock, counted on the monotonic one: pure
fixes       the pose at a tick, from the poses that the body has reported: pure
participation  begin and end of a robot's part in its team: pure
stepper     one tick: senses, crew, payloads
reports     RobotReports for observers
robot       the loop that joins gate, radio, steps, log and reports
"""
