"""The log of a run, run.mcap: its format, its writer and its reader. See docs/log.md.

layout         names and bounds that writer and reader share
schemas        message types of the log
mcap_file      the file as it is written: topics, schemas, chunks
records        the file as it is read, with bounds and checksums
ticks          the ticks of a log, from its messages
reader         a log with its scenario and summary
viewer_topics  what viewers show of a report
protobuf       encoding of the message types
descriptors    description of the message types
hashed_file    files hashed while they are written, and checked at the end
"""
