"""Random and damaged messages into the compiled core, under the sanitizers of the compiler.

build     the program, and the command that runs it.
__main__  `python -m tests.fuzz SECONDS` for a long run.
"""
