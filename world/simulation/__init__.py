"""Ground truth, one tick at a time: pure.

truth          step(state, twists) -> state.
unicycle       the unicycle (5) on its exact arc: the built-in body.
neighbor_list  pairs of robots within communication range.
crowd          memory that the contacts of a large team need.
channel        the fate of each beacon.
reception      the reception model of a channel, made once per setting.
formula        the reception models that have a formula.
table          the reception model of a table of separations.
trace          the reception model of a recorded trace, by pair and time.
shadowing      spatially correlated, reciprocal shadowing.
bursts         losses in a row.
draw_cache     the radio's uniform numbers.
hardware       sensors that err and come late, bodies that slip and lag.
core           the compiled core of the world.
"""
