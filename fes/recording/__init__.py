"""The log of a run, run.mcap, and that of a real robot: format, writer and reader. See docs/reference/log.md.

layout         names and bounds that writer and reader share
schemas        version of the log, and schemas of its JSON
mcap_file      the file as it is written: topics, schemas, chunks
records        the file as it is read, with bounds and checksums
ticks          the ticks of a log, from its messages
reader         a log with its scenario and summary
viewer_topics  messages for viewers, made from a Report
protobuf       message types described, and messages read within bounds
messages_pb2   message types of the log, generated from messages.proto
writer         the process that writes a log
robot_log      the log of a real robot: what its code received and returned
hashed_file    files hashed while they are written, and checked at the end
"""
