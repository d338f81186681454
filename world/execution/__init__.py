"""One run: its state, its log, its checkpoints.

run             one run, tick after tick
marshalling     conversion between arrays and the messages of all robots
recorder        writes the log of a run
checkpoint      state from which a run resumes after its world dies
snapshot        its file: a run at one tick
journal         every external input since the checkpoint
resume          restores a run from checkpoint and journal
directory_lock  one world per run directory
"""
