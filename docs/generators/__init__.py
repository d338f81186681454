"""Generators of the reference pages: each module makes the text of one page from the code.

built_in   the built-in extensions, with their parameters.
cli        commands, arguments and flags, from Typer and argparse.
extensions the interface of extensions, from its protocols.
markdown   headings and tables.
messages   key expressions and messages, from `fes.protocol`.
python     the Python interface, from its docstrings.
scenario   fields of a scenario, from the pydantic models.
summary    quantities of a summary.
"""
