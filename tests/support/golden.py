"""The golden digests: those of every scenario in `configs/` at its whole length, in `tests/golden/digests.toml`.

`python -m tests.support.golden` prints the file anew. They are equal on every processor, so they change only with the
laws, the channel or a scenario; CHANGELOG says why.
"""

import sys
import tomllib

from tests.support.paths import ROOT
from world.config import builtin

GOLDEN = ROOT / "tests" / "golden" / "digests.toml"


def stored() -> dict[str, str]:
    """The golden digest of each scenario by its name."""
    return tomllib.loads(GOLDEN.read_text(encoding="utf-8"))


def computed(name: str) -> str:
    """The digest of a scenario at its whole length, in one loop."""
    # A program without numpy may read the file.
    from console.backends import inprocess
    from world.config import scenario

    digest = inprocess.run(scenario.load(builtin.file_of(name)), name)["digest"]
    assert isinstance(digest, str)
    return digest


def main() -> int:
    """Print the file anew."""
    print("# Digests of the scenarios in configs, at their whole length: `python -m tests.support.golden`")
    for name in builtin.names():
        print(f'"{name}" = "{computed(name)}"', flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
