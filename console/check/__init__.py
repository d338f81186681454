"""fes check: a check that an extension keeps the rules. For pytest it is `fes.extension.conformance`.

command   fes check
rules     the rules, in order
digits    rules on digits: placement, repetition, hash seeds
handling  rules on results, inputs, state, clocks and random numbers
case      an extension and its short runs
subject   the extension, its kind, and the scenario of a short run
recorded  a recorded run, and its world or some of its robots executed again
frozen    an extension whose inputs cannot be written to
sources   clocks and global random numbers, made to raise
commands  short runs by the command fes: in processes, and with other hash seeds
"""
