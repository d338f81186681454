"""Random and damaged messages into the compiled core, under the sanitizers of the compiler.

agent.c gives them to an agent's tick, world.c to the world's reader; messages.h makes them for both.

build     the programs, and the commands that run them.
__main__  `python -m tests.fuzz SECONDS` for a long run.
"""
