"""The one check command, `python -m tests`: style, types, then every test. Further arguments go to pytest.

`python -m tests --quick` runs style, types, and the unit and architecture tests that are not slow.
All tests run in three processes, as most of their time is waiting; tests chosen by arguments run in one.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent

PARALLEL = ["-n", "3", "--dist", "loadfile", "--no-loadscope-reorder"]
"""Three processes, each with complete files, in their order: xdist would start the longest file last."""

QUICK = [*PARALLEL, "-q", "-m", "not slow", "--hypothesis-profile", "quick"]
QUICK += ["tests/unit", "tests/architecture", "fes", "agents", "world", "field", "console"]
"""The folders of quick tests, and the doctests; hypothesis generates a fifth of its examples."""

CHOSEN = QUICK + sys.argv[2:] if sys.argv[1:2] == ["--quick"] else sys.argv[1:] or PARALLEL

CHECKS = (
    ["ruff", "check", "."],
    ["ruff", "format", "--check", "."],
    ["mypy"],
    ["pytest", *CHOSEN],
)


def main() -> int:
    """Run all checks, also after one failed; returns 1 if any did."""
    failed = []
    for name, *words in CHECKS:
        print(f"== {name} {' '.join(words)}", flush=True)
        if subprocess.run([sys.executable, "-m", name, *words], cwd=ROOT, check=False).returncode != 0:
            failed.append(name)
    print(f"failed: {', '.join(failed)}" if failed else "all checks passed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
