"""The formation law "marks and plans": the whole team takes up one configuration, and keeps it when robots die.

law         the law: marks at the start of a period, then the plan made of them, then the pull.
clock       periods on each robot's own clock.
table       the marks that each robot knows.
exchange    marks in beacons: what a robot sends, and which marks it accepts.
planning    the plan of a set of marks: the same bytes give the same plan at every robot.
assignment  assignment of robots to slots with the least sum of costs.
connection  proof that a team stays connected on its way.
approach    where a robot goes by its plan, and where it will be.
"""
