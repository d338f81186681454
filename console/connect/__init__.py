"""Access to running worlds, and their run directories.

run_directory    run directories: files, and the address of a running run
index_source     the source of the index: oracle, measured or sampled
observer         the reports of a running world
reach            a run as the flags of a command name it, and a session with it
options          arguments and flags that several commands share
channel_request  a change of the channel, requested from the world
set_command      the command fes set
"""
