"""The site of the documentation, built strictly: `python -m tests.support.site` needs the extra `docs`.

A broken link, a page outside of the navigation, or a file from another host is an error. It takes some seconds.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.support.paths import ROOT

ASSET = re.compile(
    r"""<(?:script|img|iframe|link(?=[^>]*rel="?(?:stylesheet|preconnect|icon)))[^>]*?https?://[^>]*>"""
)
"""An element for which a browser asks another host."""


def external_assets(site: Path) -> list[str]:
    """Elements of the built pages that load something from another host."""
    return [
        f"{page.relative_to(site)}: {element}"
        for page in sorted(site.rglob("*.html"))
        for element in ASSET.findall(page.read_text(encoding="utf-8"))
    ]


def main() -> int:
    """Build the site in a temporary folder and check it; returns 1 if there is an error."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", folder]
        quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
        if subprocess.run(words, cwd=ROOT, env=quiet, check=False).returncode != 0:
            return 1
        assets = external_assets(Path(folder))
    print(*assets, f"{len(assets)} files from other hosts", sep="\n")
    return 1 if assets else 0


if __name__ == "__main__":
    sys.exit(main())
