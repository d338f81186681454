"""The golden digests: those of every scenario in `configs/` at its whole length, in `tests/golden/digests.toml`.

`python -m tests.support.golden` prints the file anew. They are equal on every processor, so they change only with the
laws, the channel or a scenario; CHANGELOG says why.
"""

import sys
import tomllib

from tests.support.paths import ROOT
from world.config import builtin

GOLDEN = ROOT / "tests" / "golden" / "digests.toml"


CUT = (("challenge", 20.0),)
"""Scenarios of which CI computes only the first seconds [s]."""


def stored() -> dict[str, str]:
    """The golden digest of each scenario by its name, at its whole length."""
    return {name: digest for name, digest in _all().items() if "," not in name}


def stored_cut(name: str, seconds: float) -> str:
    """The golden digest of the first `seconds` of a scenario in CUT."""
    return _all()[f"{name}, {seconds:g}"]


def _all() -> dict[str, str]:
    return tomllib.loads(GOLDEN.read_text(encoding="utf-8"))


def computed(name: str, seconds: float | None = None) -> str:
    """The digest of a scenario in one loop: at its whole length, or cut to `seconds` of simulated time."""
    # A program without numpy may read the file.
    from console.backends import inprocess
    from world.config import scenario

    length = {} if seconds is None else {"run.duration": seconds}
    digest = inprocess.run(scenario.load(builtin.file_of(name), length), name)["digest"]
    assert isinstance(digest, str)
    return digest


def main() -> int:
    """Print the file anew."""
    print("# Digests of the scenarios in configs, at their whole length: `python -m tests.support.golden`")
    for name in builtin.names():
        print(f'"{name}" = "{computed(name)}"', flush=True)
    print("\n# The first seconds of a long one: `name, seconds`")
    for name, seconds in CUT:
        print(f'"{name}, {seconds:g}" = "{computed(name, seconds)}"', flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
