"""The files of a release: `python -m deploy.wheels` builds them, each for its platform.

__main__   the command
platforms  the platforms, and the compiler's words for each
libraries  the headers of compiled libraries: the machine, and the oldest system
contents   the rules for a finished file

All import only Python's own library: tests/portability runs them with a Python that has no other.
"""
