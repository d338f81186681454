"""Settings of hypothesis: the same examples in every run, and no wall-clock deadline for an example."""

from hypothesis import settings

settings.register_profile("fes", derandomize=True, deadline=None)
settings.load_profile("fes")
