"""compose.yaml on a real container engine: `tests/compose/run` starts the engine, then this package checks claims.

__main__    the claims, in turn
walls       claims of what a container may do
engine      Docker's command line, and the engine's network namespace

They need only the standard library, as the machine's Python may have no other.
"""
