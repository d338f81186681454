"""One run: its state, its log, its checkpoints.

run             one run, tick after tick
barrier         the answers that a tick in lockstep waits for
live_tick       the answers that robots follow on the live clock
lifecycle       the robots that take part in a tick, and those that hang
hosting         which agent hosts which robot, and its lease
marshalling     conversion between arrays and the messages of all robots
recorder        writes the log of a run
checkpoint      state from which a run resumes after its world dies
snapshot        its file: a run at one tick
journal         every external input since the checkpoint
resume          restores a run from checkpoint and journal
directory_lock  one world per run directory
"""
