"""Settings of hypothesis: the same examples in every run, and no wall-clock deadline for an example.

Tests send stop signals, which the background job of a script ignores and its children inherit: here they are not.
"""

import signal

from hypothesis import settings

settings.register_profile("fes", derandomize=True, deadline=None)
settings.load_profile("fes")

signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
