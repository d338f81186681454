"""Settings compared with the first one: outputs, logs and wheels, and what came of them."""

import time
from collections.abc import Callable
from pathlib import Path

from fes.arithmetic.core import library
from tests.portability import settings, wheels
from tests.portability.downloads import Unavailable
from tests.portability.interpreters import Interpreter, Workshop, is_stopped
from tests.portability.settings import Setting
from tests.portability.verdict import Output
from tests.support import golden
from world.config import builtin

SHORT = "2"
"""Simulated seconds of each case in the short form, and of each log in every form."""

GOLDEN = ("pair",)
"""Scenarios that each wheel runs to their end, against the golden digests."""

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
        self.few = [] if self.is_short or self.is_whole else ["--emulated"]
        """Words for an emulated processor."""
        self.failed: list[str] = []
        self.missing: list[str] = []
        self.equal = 0

    def digests(self, setting: Setting, *words: str) -> Output | None:
        """The output under a setting; None if it failed, which is said. By default numpy computes."""
        path = self.outputs / f"{setting.name.replace(' ', '-')}.txt"
        words = ("-m", "tests.portability.digests", *self.words, *words)
        code = setting.interpreter.run(path, *words, **{library.VARIABLE: library.NUMPY} | setting.environment)
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
        except wheels.Broken as output:
            self.fail(f"{name}: {output}")

    def wheel(self, base: Output, plain: Interpreter, machine: str, built: Path | None, *words: str) -> None:
        """The compiled core of a wheel: the cases, and some scenarios to their end. Raises Unavailable."""
        if built is None:
            raise Unavailable(f"none is made for {machine}")
        setting = settings.compiled(wheels.installed(plain, built, self.workshop.pip, self.workshop.folder))
        self.compare(base, setting, *words)
        if self.is_whole:  # the first setting was compared with the golden digests
            return
        setting = setting._replace(name=f"{setting.name}, golden")
        if (output := self.digests(setting, "--whole", *GOLDEN)) is None:
            return
        stored = golden.stored()
        if unequal := output.unlike({name: stored[name] for name in GOLDEN}):
            self.fail(f"{setting.name}: these are not golden: {', '.join(unequal)}")
        else:
            self.equal += 1
            say(f"{setting.name}: {', '.join(GOLDEN)} have their golden digests; {output.about['core']}")
