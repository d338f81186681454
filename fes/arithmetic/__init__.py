"""Elementary functions as fixed sequences of IEEE 754 operations, and random numbers: the same bits everywhere.

elementary    all functions, on one page
exponential   exp(x) and 1 - exp(-a)
logarithm     log(x) and log(1 + x)
power         x to a real power
trigonometry  sin and cos
angle         atan2
polynomial    polynomials
sums          sums and matrix products in a fixed order
exact         rounding to an integer, bits, and errors of products
draws         random numbers as a function of (seed, stream, tick, sender, receiver)
core          the compiled elementary functions, and the choice of the core
"""
