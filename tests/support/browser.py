"""A real Chromium without a screen, driven by Selenium, and the pages of fes that it opens.

Chromium resolves no name, so a page that needed the network would show an error. Without a Chromium the tests are
skipped, and loudly so.
"""

import contextlib
import importlib.util
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from fes.system import distribution
from tests.support.processes import PATIENCE, fes, start, until

PROGRAMS = {"chromium": ("chromium", "chromium-browser", "google-chrome"), "chromedriver": ("chromedriver",)}
"""Names of the browser, and of the program that drives it (Debian: chromium and chromium-driver)."""

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
)

FIND = """
const find = (root, selector) => {
  for (const element of root.querySelectorAll("*")) {
    if (element.matches(selector)) return element
    const inside = element.shadowRoot && find(element.shadowRoot, selector)
    if (inside) return inside
  }
  return null
}
const model = name => window.Bokeh && Bokeh.documents.length ? Bokeh.documents[0].get_model_by_name(name) : null
"""
"""Look-ups in a page: an element, also below the shadow roots of Bokeh, and a model of Bokeh by its name."""

SIZE = (1400, 900)
"""Size of a window [pixels]."""


def _program(kind: str) -> str | None:
    return next(filter(None, map(shutil.which, PROGRAMS[kind])), None)


needs_browser = pytest.mark.skipif(
    not all(map(_program, PROGRAMS)) or not all(map(importlib.util.find_spec, ("selenium", "bokeh"))),
    reason="no Chromium, or no driver of it: these tests run after apt-get install chromium chromium-driver, "
    f"and {distribution.install('dev')}",
)


class Browser:
    """One browser, with one page."""

    def __init__(self, profile: Path, size: tuple[int, int] = SIZE) -> None:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        options = webdriver.ChromeOptions()
        options.binary_location = str(_program("chromium"))
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver: Any = webdriver.Chrome(options=options, service=Service(_program("chromedriver")))
        self.driver.set_page_load_timeout(PATIENCE)
        self.driver.set_script_timeout(PATIENCE)
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    def open(self, address: str) -> None:
        """Open a page of fes, and wait until Bokeh has drawn it; errors of the page before it are forgotten."""
        self.driver.get("about:blank")
        self.errors()
        self.driver.get(address)
        until(lambda: self.run("return find(document, '.facts') !== null"))

    def run(self, script: str, *values: Any) -> Any:
        """The result of a script, with the look-ups of FIND."""
        return self.driver.execute_script(FIND + script, *values)

    def column(self, source: str, name: str) -> list[Any]:
        """A column of a source of data; empty before it is there."""
        script = "const found = model(arguments[0]); return found ? Array.from(found.data[arguments[1]] || []) : []"
        return cast(list[Any], self.run(script, source, name))

    def text(self, name: str) -> str:
        """The text of a Div of Bokeh as HTML; empty before it is there."""
        return str(self.run("return (model(arguments[0]) || {text: ''}).text", name))

    def tick(self) -> int:
        """The tick in the header; -1 before the first report."""
        shown = self.text("header").partition("tick <b>")[2].partition(" /")[0]
        return int(shown.replace(",", "")) if shown else -1

    def element(self, selector: str) -> Any:
        """An element of the page."""
        return until(lambda: self.run("return find(document, arguments[0])", selector))

    def resources(self) -> list[str]:
        """Addresses of everything that the page has loaded."""
        return cast(list[str], self.run("return performance.getEntries().map(entry => entry.name)"))

    def errors(self) -> list[str]:
        """Errors on the console since the last call."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]


@contextlib.contextmanager
def browser(folder: Path, size: tuple[int, int] = SIZE) -> Iterator[Browser]:
    """A browser with a profile of its own in `folder`."""
    opened = Browser(folder, size)
    try:
        yield opened
    finally:
        opened.driver.quit()


@contextlib.contextmanager
def page(where: Path, *words: str) -> Iterator[tuple[str, "subprocess.Popen[str]"]]:
    """The address of a page that `fes` serves with these words, and its process, which is ended by a signal."""
    serving = start(fes(*words, "--web", "--port", "0"), where)
    try:
        assert serving.stdout is not None
        address = serving.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:"), (address, serving.communicate(timeout=PATIENCE))
        yield address, serving
        assert serving.poll() is None, serving.communicate()
        serving.terminate()
        _, complaints = serving.communicate(timeout=PATIENCE)
        ended = (serving.returncode, complaints)
        assert ended == (0, ""), ended
    finally:
        if serving.poll() is None:
            serving.kill()
            serving.communicate()
