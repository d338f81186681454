"""Parts of a scenario that are not in its file.

extensions  the code of its extensions, and whether it is that of a recorded run
trace_file  the file of a trace
"""
