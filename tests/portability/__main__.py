"""One digest under every setting: `python -m tests.portability [short|whole|SECONDS]`; `run` beside it starts this.

Exit codes: 0 all are equal, 1 something differs or failed, 77 nothing could be compared.
"""

import argparse
import os
import signal
import sys
import tempfile
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from tests.portability import settings, wheels
from tests.portability.comparison import SHORT, Comparison, say
from tests.portability.downloads import ROOT, Unavailable
from tests.portability.interpreters import STOPPED, Interpreter, is_stopped, stop
from tests.portability.settings import Setting
from tests.portability.verdict import Output
from tests.support import golden

FAILED, SKIPPED = 1, 77

LONGEST = 1e4
"""Most simulated seconds that can be asked for."""


class Settings(Comparison):
    """All settings of one call."""

    def emulated(self, base: Output, own: Interpreter, other: "Future[Interpreter]") -> None:
        """Another kind of processor."""

        def both() -> None:
            self.compare(base, settings.plain(other.result()), *self.few)
            self.logs(own, other.result())

        self.attempt("aarch64", both)

    def build(self) -> dict[str, Path]:
        """Wheels with the compiled core, by machine."""
        return wheels.build(self.workshop.folder, wheels.ALL if self.is_whole else wheels.FEW)

    def compiled(
        self, base: Output, own: Interpreter, other: "Future[Interpreter]", built: "Future[dict[str, Path]]"
    ) -> None:
        """The compiled core of this clone, and those of the wheels."""
        if (ROOT / "fes/arithmetic/core/libelementary.so").exists():
            self.compare(base, settings.compiled(own))
        else:
            self.miss("the compiled core of this clone was not built: python build_core.py")
        machine = self.workshop.machine
        self.attempt(f"wheel for {machine}", lambda: self.wheel(base, own, machine, built.result().get(machine)))
        self.attempt(
            "wheel for aarch64",
            lambda: self.wheel(base, other.result(), "aarch64", built.result().get("aarch64"), *self.few),
        )

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
            other, built = pool.submit(self.workshop.emulated), pool.submit(self.build)
            done = [pool.submit(self.emulated, base, own, other)]  # the longest first
            done += [pool.submit(self.compare, base, setting) for setting in changed]
            done.append(pool.submit(self.others, base))
            done.append(pool.submit(self.compiled, base, own, other, built))
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
            return Settings(form, folder, outputs).all()
        except Unavailable as reason:
            say(f"skipped, because {reason}")
            return SKIPPED


if __name__ == "__main__":
    sys.exit(main())
