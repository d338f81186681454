"""One digest under every setting: `python -m tests.portability [short|whole|SECONDS]`; `run` beside it starts this.

Exit codes: 0 all are equal, 1 something differs or failed, 77 nothing could be compared.
"""

import argparse
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.portability import settings
from tests.portability.downloads import Unavailable
from tests.portability.interpreters import STOPPED, Interpreter, Workshop, is_stopped, stop
from tests.portability.settings import Setting
from tests.portability.verdict import Output
from tests.support import golden
from world.config import builtin

FAILED, SKIPPED = 1, 77
SHORT = "2"
"""Simulated seconds of each case in the short form, and of each log in every form."""

LONGEST = 1e4
"""Most simulated seconds that can be asked for."""

BEGUN = time.monotonic()


def say(text: str) -> None:
    """Print a line with the time since the start."""
    print(f"portability: [{time.monotonic() - BEGUN:.0f} s] {text}", flush=True)


class Comparison:
    """All settings of one call, and what came of them."""

    def __init__(self, form: str, folder: Path, outputs: Path) -> None:
        self.workshop = Workshop(folder)
        self.outputs = outputs
        self.is_short, self.is_whole = form == "short", form == "whole"
        self.words = ["--seconds", form]
        if self.is_short:
            self.words = ["--seconds", SHORT, "--emulated"]
        elif self.is_whole:
            self.words = ["--whole", *builtin.names()]
        self.failed: list[str] = []
        self.missing: list[str] = []
        self.equal = 0

    def digests(self, setting: Setting, *words: str) -> Output | None:
        """The output under a setting; None if it failed, which is said."""
        path = self.outputs / f"{setting.name.replace(' ', '-')}.txt"
        words = ("-m", "tests.portability.digests", *self.words, *words)
        code = setting.interpreter.run(path, *words, **setting.environment)
        if code != 0:
            self.fail(f"{setting.name}: exit code {code}: {(path.read_text().splitlines() or [''])[-1]}")
            return None
        return Output.read(path)

    def fail(self, text: str) -> None:
        """Note a failure, and say it."""
        if is_stopped():
            return
        self.failed.append(text)
        say(f"FAILED: {text}")

    def miss(self, text: str) -> None:
        """Note what could not be run, and say it."""
        if is_stopped():
            return
        self.missing.append(text)
        say(f"!! SKIPPED: {text}")

    def compare(self, base: Output, setting: Setting, *words: str) -> None:
        """Run under a setting, and compare with `base`."""
        if (output := self.digests(setting, *words)) is None:
            return
        about = f"{setting.name}: {setting.describe()} {output.effect(base)}".replace(":  ", ": ")
        if found := output.differences(base):
            self.fail(f"{about}; these differ: {', '.join(found)}")
        else:
            self.equal += 1
            say(f"{about}; {len(output.lines)} cases are equal")
            say(f"    {output.about['machine']}; numpy {output.about['numpy']}; {output.about['features']}")

    def logs(self, here: Interpreter, there: Interpreter) -> None:
        """Logs that `here` records, executed by `there`, and the reverse."""
        for first, second in ((here, there), (there, here)):
            folder, path = self.outputs / f"logs-of-{first.name}", self.outputs / f"logs-of-{first.name}.txt"
            for interpreter, word in ((first, "record"), (second, "execute")):
                words = ("-m", "tests.portability.logs", word, str(folder), "--seconds", SHORT)
                if code := interpreter.run(path, *words):
                    self.fail(f"logs of {first.name}, {word} by {interpreter.name}: code {code}\n{path.read_text()}")
                    return
            self.equal += 1
            number = len(path.read_text().splitlines())
            say(f"{number} logs of {first.name} are executed by {second.name}, bit for bit")

    def attempt(self, name: str, what: Callable[[], None]) -> None:
        """Do something that needs a download; say if that is not possible."""
        try:
            what()
        except Unavailable as reason:
            self.miss(f"{name}: {reason}")

    def emulated(self, base: Output, own: Interpreter) -> None:
        """Another kind of processor."""

        def both() -> None:
            other = self.workshop.emulated()
            self.compare(base, settings.plain(other), *([] if self.is_short or self.is_whole else ["--emulated"]))
            self.logs(own, other)

        self.attempt("aarch64", both)

    def others(self, base: Output) -> None:
        """The oldest numpy, and other Pythons."""

        def oldest() -> None:
            own = self.workshop.own(oldest=True)
            changed, _ = settings.loops(own)
            for setting in (settings.plain(own), *([] if self.is_short else changed[-1:])):
                self.compare(base, Setting(f"oldest numpy, {setting.name}", own, setting.environment))

        def pythons() -> None:
            found = self.workshop.others()
            for other in found[:1] if self.is_short else found:
                self.compare(base, settings.plain(other))
            if not found:
                self.miss("no other Python is on this machine")

        def debian() -> None:
            self.compare(base, settings.plain(self.workshop.of_next_debian()))

        self.attempt("the oldest numpy", oldest)
        self.attempt("another Python", pythons)
        if not self.is_short or not self.workshop.has_others:
            self.attempt("Python and C library of Debian 13", debian)

    def all(self) -> int:
        """Run everything; returns the exit code."""
        own = self.workshop.own()
        base = self.digests(settings.plain(own))
        if base is None:
            return FAILED
        say(f"first setting: {base.about['machine']}; numpy {base.about['numpy']}; {base.about['features']}")
        if self.is_whole and (unequal := base.unlike(golden.stored())):
            self.fail(f"first setting: these are not golden: {', '.join(unequal)}")
        changed, remarks = settings.loops(own)
        for remark in remarks:
            say(remark)
        changed += settings.of_libraries(own, settings.FEW_CORES if self.is_short else settings.CORES)
        if not self.is_short:
            changed.append(settings.together(changed))
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            done = [pool.submit(self.emulated, base, own)]  # the longest first
            done += [pool.submit(self.compare, base, setting) for setting in changed]
            done.append(pool.submit(self.others, base))
        for one in done:
            one.result()
        if is_stopped():
            say("stopped")
            return STOPPED
        for text in self.missing:
            say(f"!! not tested: {text}")
        for text in self.failed:
            say(f"FAILED: {text}")
        if self.failed:
            return FAILED
        say(f"{len(base.lines)} cases, {self.equal} comparisons: all are equal")
        return 0


def _form(text: str) -> str:
    """The form: a name, or a length from SHORT to LONGEST; raises ArgumentTypeError for another text."""
    if text not in ("short", "whole"):
        try:
            is_length = float(SHORT) <= float(text) <= LONGEST
        except ValueError:
            is_length = False
        if not is_length:
            raise argparse.ArgumentTypeError(f"expects short, whole, or seconds from {SHORT} to {LONGEST:g}")
    return text


def main() -> int:
    """Check the arguments, and run."""
    parser = argparse.ArgumentParser(prog="tests/portability/run", description="one digest under every setting")
    parser.add_argument("form", nargs="?", default="short", type=_form, help="short, whole, or simulated seconds")
    form = parser.parse_args().form
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: stop())
    with tempfile.TemporaryDirectory(prefix="fes-portability-") as work:
        folder = Path(os.environ.get("FES_PORTABILITY_CACHE", work)).absolute()
        outputs = Path(os.environ.get("FES_PORTABILITY_OUTPUTS", Path(work) / "outputs")).absolute()
        for place in (folder, outputs):
            place.mkdir(parents=True, exist_ok=True)
        try:
            return Comparison(form, folder, outputs).all()
        except Unavailable as reason:
            say(f"skipped, because {reason}")
            return SKIPPED


if __name__ == "__main__":
    sys.exit(main())
