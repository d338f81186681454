"""The conformance kit, for pytest: an AssertionError with one line per rule that an extension breaks.

    from fes.extension.conformance import check

    def test_my_law_keeps_the_rules():
        check("mylab:Mine")

The kit runs worlds, crews and commands, so it lies above all of them, in `console.check`. It is loaded by name here,
as the registry loads laws: `fes` imports nothing above itself.
"""

import importlib
from typing import Any


def check(extension: str | type, kind: str | None = None, **parameters: Any) -> None:
    """Check an extension by short runs, as `fes check` does.

    `extension` is a class, `module:Class`, or the name of an installed extension; `kind` is needed only if its
    methods fit several kinds. `parameters` are those of the extension.

    Raises AssertionError with one line per broken rule, and FesError in one line if there is no such extension.
    """
    failures = importlib.import_module("console.check.rules").failures(extension, kind, parameters)
    assert not failures, "\n".join(failures)
