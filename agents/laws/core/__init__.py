"""The compiled index of the oracle, a library of its own.

formula_index  the index of the channel's formula.
"""
