"""The rules that an extension keeps, in order."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from console.check import digits, handling, subject
from console.check.case import Case
from console.check.subject import Subject
from fes.errors import FesError


class Finding(NamedTuple):
    """The result of one rule."""

    rule: str
    text: str
    failure: str
    """The failure, in one line that names the extension and the rule; empty if the rule is kept."""


Check = Callable[[Case], str]
"""Returns the breach of a rule, or an empty text. It may raise FesError instead."""


class Rule(NamedTuple):
    """A rule of extensions."""

    name: str
    text: str
    check: Check
    is_of_laws: bool = False
    """True for a rule that concerns only extensions that robots execute."""


def _concerning(checked: Subject) -> list[Rule]:
    return [rule for rule in RULES if checked.is_law or not rule.is_of_laws]


def findings(checked: Subject) -> Iterator[Finding]:
    """The result of each rule that concerns the extension; they end with the first two if one of those is broken."""
    case = Case(checked)
    for number, rule in enumerate(_concerning(checked)):
        try:
            failure = rule.check(case)
        except FesError as error:
            failure = " ".join(str(error).split())
        failure = failure.removeprefix("check: ").partition(f"{checked.title}: ")[2] or failure
        yield Finding(rule.name, rule.text, f"{checked.title}: {rule.name}: {failure}" if failure else "")
        if failure and number < 2:
            return


def count(checked: Subject) -> int:
    """Number of rules that concern the extension."""
    return len(_concerning(checked))


def failures(extension: str | type, kind: str | None, parameters: dict[str, Any]) -> list[str]:
    """The failures of an extension, one line per broken rule; raises FesError if there is no such extension."""
    return [finding.failure for finding in findings(subject.of(extension, kind, parameters)) if finding.failure]


RULES = (
    Rule("interface", "it has the methods of its kind, and takes its parameters", handling.interface),
    Rule("values", "results have the right shapes and types, and are finite", handling.values),
    Rule("repeat", "the same digits when repeated", digits.repeated),
    Rule("alone", "the same digits for a robot alone as in a crew of all", digits.alone, is_of_laws=True),
    Rule("crews", "the same digits in crews of 3 and 2 robots", digits.crews, is_of_laws=True),
    Rule("stacked", "the same digits in a stack of three runs", digits.stacked),
    Rule("inputs", "inputs and state are not written to", handling.inputs),
    Rule("state", "the state can be pickled, and a run resumed from it has the same digits", handling.state),
    Rule("restart", "a robot that restarts equals a new one", handling.restart, is_of_laws=True),
    Rule("clock", "no clock is read", handling.clock),
    Rule("randomness", "no random numbers are used but those of the context", handling.randomness),
    Rule("hashing", "the same digits with another PYTHONHASHSEED", digits.hashing),
    Rule("processes", "the same digits in processes and in one loop", digits.processes),
)
