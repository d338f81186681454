"""Number of examples that hypothesis generates per test: fewer in `python -m tests --quick`."""

from hypothesis import settings

EXAMPLES = settings().max_examples
