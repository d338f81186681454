"""Ground truth, one tick at a time: pure.

truth          step(state, twists) -> state.
unicycle       the unicycle (5) on its exact arc.
neighbor_list  pairs of robots within communication range.
crowd          memory that the contacts of a large team need.
channel        the fate of each beacon.
shadowing      spatially correlated, reciprocal shadowing.
bursts         losses in a row.
draw_cache     the radio's uniform numbers.
"""
