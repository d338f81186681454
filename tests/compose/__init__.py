"""compose.yaml on a container engine: `tests/compose/run` starts the engine, then this package checks the claims.

__main__    the claims, in sequence;
walls       claims about the privileges of containers;
engine      Docker's command line, and the engine's network namespace.

The modules import only Python's own library, because the machine's Python has no other.
"""
