"""The writer of a log: a process of its own, so that a recorded run computes its ticks at almost full speed.

frames      what a run tells the writer, and its answers, as bytes on a pipe
log_file    the log as the writer makes it from frames: messages, topics for viewers, chunks
connection  the run's side: starts the writer, and gives it each tick
process     the writer's side: from its start to the end of its pipe
"""
