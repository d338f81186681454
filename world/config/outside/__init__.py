"""Parts of a scenario outside its tables.

extensions  the code of its extensions, and whether it is that of a recorded run
trace_file  the file of a trace
schemes     named variants in its file, and the columns of their table
"""
