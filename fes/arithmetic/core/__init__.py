"""The compiled elementary functions and random numbers, and the choice of the core: C, or numpy with the same bits.

library    which compiled libraries this process uses.
functions  the compiled functions, with the shapes of `fes.arithmetic.elementary`.
"""
