"""The machine: files, text, signals, memory.

files           files from others, read with a bound on their size
number_columns  columns of numbers in a comma-separated file
encoding        text from outside: files, arguments and names, in any encoding
output          text that leaves a process: any encoding, no control characters
background_log  a log that never waits for its reader
strict_json     JSON without NaN and Infinity
signals         stop signals during imports, and cleanups before a second signal ends a process
memory          available memory
distribution    name and version of the installed distribution
fingerprint     hash of the elementary functions: equal on every processor
"""
