"""Picture of the page of a measured run: `python -m tests.support.web_picture docs/web.png`."""

import argparse
import tempfile
import time
from pathlib import Path

from tests.support.browser import SIZE, browser, page
from tests.support.processes import PATIENCE, fes, start, until

LEARNT = 3000
"""Tick of the picture, at which the robots have learnt the channel."""

SETTLED = 3.0
"""Time for the browser to draw all panels [s]."""


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.web_picture", description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--scenario", default="measured")
    parser.add_argument("--size", type=int, nargs=2, default=SIZE, metavar=("WIDTH", "HEIGHT"))
    flags = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        words = [flags.scenario, "--duration", "1000", "--rtf", "4", "--headless"]
        running = start(fes("run", *words), where)
        try:
            until(lambda: list(where.glob("runs/*/endpoint.json")))
            with page(where, "view") as (address, _), browser(where / "profile", tuple(flags.size)) as window:
                window.open(address)
                until(lambda: window.tick() > LEARNT)
                time.sleep(SETTLED)
                window.driver.save_screenshot(str(flags.file))
        finally:
            running.terminate()
            running.communicate(timeout=PATIENCE)


if __name__ == "__main__":
    main()
