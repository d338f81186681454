"""Running worlds, and what they leave on disk.

run_directory  run directories
observer       the reports of a running world
options        flags that several commands share
set_command    the command fes set
"""
