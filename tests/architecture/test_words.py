"""Plain English: the project's prose and names keep the rules that CONTRIBUTING.md has."""

from pathlib import Path

import pytest

from tests.support.paths import ROOT
from tests.support.prose import Prose, prose_of
from tests.support.words import CHECKED, PRODUCT, files_of, identifiers, offences, offences_of


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", CHECKED, ids=name_of)
def test_prose_is_plain_english(path: Path) -> None:
    assert [str(offence) for offence in offences(path)] == []


@pytest.mark.parametrize("path", [path for path in files_of(*PRODUCT) if path.suffix == ".py"], ids=name_of)
def test_no_name_is_one_that_another_name_has_replaced(path: Path) -> None:
    assert [str(offence) for offence in identifiers(path)] == []


REWRITTEN = [
    ("What is wrong says what to do, and then the exit code is 1",
     "Each failed check prints a remedy, and the command exits with 1."),
    ("nobody at the endpoint is no failure",
     "An unreachable endpoint is not a failure unless you named a run; "
     "neither is a world that `fes run` is restarting."),
    ("What does not fit the terminal is left out, the least needed first.",
     "In a small terminal the least important panels are hidden first."),
    ("What no summary can meet, such as a key that it does not have, is refused before the run.",
     "Impossible expectations (an unknown key, say) are rejected before the run starts."),
    ("changes the channel of a run that goes on, unless a later event would then be impossible",
     "changes the channel of a running run; rejected if a later scheduled event would become invalid"),
    ("who crashes or is cut off is left out until it is back",
     "A robot whose agent crashes or is disconnected is excluded until it reconnects."),
    ("the agents are dismissed; but not while a world that came back only waits for them.",
     "Only Ctrl-C (SIGINT) ends a run permanently and dismisses the agents. "
     "Exception: a resumed world that is still waiting for its agents."),
    ("r\\* is that of the formula, whatever lies over it.",
     "r\\* is computed from the formula alone, without shadowing, bursts, jammers and partitions."),
    ("A checkpoint can run nothing", "Loading a checkpoint cannot execute code."),
    ("Nothing that cannot be gone on with is", "Invalid checkpoints are rejected."),
    ("An old command is no command", "Commands older than 0.25 s are ignored."),
    ("Whoever is gone is started again", "Every process that dies is restarted."),
    ("To end one for good", "To end a run permanently"),
    ("What a run can be gone on from if its world dies",
     "Checkpoints: state from which a run resumes after its world dies"),
    ("Whom only the scenario has dead must not fall behind.",
     "Agents whose robots are dead only by schedule still receive observations, so that they keep up."),
    ("who comes back would change what others sense of it",
     "a robot that rejoined now would change what was already published for this tick"),
    ("A second answer to an earlier tick is no fault of a robot that was asked again for it",
     "A duplicate answer is not an error if we re-sent the request just as the robot answered."),
    ("A learner is one row of the arrays. Who learns is a learner.",
     "A *learner* is one row of the arrays: a robot with pooling, a link end without."),
    ("What came that should not have come, and what did not that should have",
     "Rejected and missing messages: counted, and logged once per kind."),
    ("Who comes back begins anew", "A robot that rejoins starts without state."),
    ("The bus refuses it. Whose beacons are lost is drawn anew.", "The draw decides which beacons are lost."),
    ("4 KiB a peer", "4 KiB per peer"), ("one line a kind", "one line per kind"),
    ("it is logged once a tick", "it is logged once per tick"),
    ("All that there was of it is lost.", "The whole run is lost."),
    ("Agents are turned away.", "Agents are rejected."), ("It gave up.", "It timed out."),
    ("The run is under way.", "The run is active."), ("Zenoh refuses it, and says so.", "Zenoh logs the rejection."),
    ("A sentence that has one clause, and another one that follows from it, and a third for good measure, as its "
     "author could not find any end to it.",
     "A sentence has one clause. Another sentence follows from it."),
]  # fmt: skip
"""A sentence that the checker must report, and a plain one with the same fact. The first ones are negative examples
from earlier versions, and are no longer prose of the project."""


@pytest.mark.parametrize("text", [before for before, _ in REWRITTEN])
def test_prose_that_is_hard_to_read_is_found(text: str) -> None:
    assert list(offences_of(Prose(1, text))) != []


PLAIN = [
    "Robot 3 can publish only on its own keys; an observer cannot publish.",
    "Results are bit-identical on every machine with the same version.",
    "Pass criteria: no process exits unless the test killed it.",
    "Excludes processes suspended by schedule, whose queues must stay empty.",
    "otherwise it has joined but does not take part yet",
    "The token is no longer there.", "There is no log.", "It says that there is no robot 3.", "It costs nothing.",
    "What does it cost? What is said here?", "the message a robot sends", "x = [a, b] + c d e f g h i j k l m n",
    "r_ij = 1 + 2 - 3 * 4 / 5 = 6 + 7 - 8 * 9 / 10 = 11 + 12 - 13 * 14 / 15 = 16 + 17 - 18 = 19",
]  # fmt: skip
"""Plain sentences that are near to a rule."""


@pytest.mark.parametrize("text", [*(after for _, after in REWRITTEN), *PLAIN])
def test_prose_that_is_plain_passes(text: str) -> None:
    assert list(offences_of(Prose(1, text, opens=True))) == []


@pytest.mark.parametrize(
    "docstring",
    ["That is shown.", "Not a process that hangs.", "Whether it is there.", "How far it is.", "Where it stands."],
)
def test_a_docstring_that_opens_with_a_relative_is_found(docstring: str) -> None:
    assert list(offences_of(Prose(1, docstring, opens=True))) != []
    assert list(offences_of(Prose(1, docstring))) == []


MODULE = '''
"""A map of modules.

world  what
       holds
run    one | two

A paragraph of
two lines.

- an item

>>> 1 + 1
2
"""

LIMIT = 1
"""Limit [s]."""


def test_who_comes_back() -> None:
    """Docstring of a function."""
    # a comment of
    # two lines
    print(f"a message of {LIMIT} words", "short", """code
of a program in a program""")
'''


def test_every_docstring_message_and_comment_of_a_module_is_prose(tmp_path: Path) -> None:
    path = tmp_path / "test_module.py"
    path.write_text(MODULE, encoding="utf-8")
    pieces = list(prose_of(path))
    assert [(piece.line, piece.text.strip()) for piece in pieces if piece.opens] == [
        (2, "A map of modules."), (18, "Limit [s]."), (22, "Docstring of a function."),
    ]  # fmt: skip
    assert [(piece.line, piece.text.strip()) for piece in pieces if piece.text and not piece.opens] == [
        (4, "world  what"), (5, "holds"), (6, "run    one | two"), (8, "A paragraph of two lines."), (11, "an item"),
        (25, "a message of x words"), (23, "a comment of two lines"),
    ]  # fmt: skip


def test_a_page_is_read_by_paragraph_item_and_cell_without_headings_and_code(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# What it is\n\nOne\ntwo.\n- three\n\n```\nWho is it\n```\n\n    code\n\n| a b | c |\n|---|\n")
    assert [(piece.line, piece.text) for piece in prose_of(page)] == [
        (3, "One two."), (5, "three"), (13, "a b"), (13, "c"),
    ]  # fmt: skip


def test_the_name_of_a_test_is_prose_too(tmp_path: Path) -> None:
    path = tmp_path / "test_module.py"
    path.write_text(MODULE, encoding="utf-8")
    assert [offence.text for offence in offences(path)] == ["test_who_comes_back", "who comes back"]


@pytest.mark.parametrize(
    ("code", "replaced"),
    [
        ("found = one, at = 1, 2", ["found", "at", "one"]),
        ("def f(told, *, said): pass", ["told", "said"]),
        ("class Course: pass", ["Course"]),
        ("self._roster = [here for here in x]", ["here", "_roster"]),
        ("for other in x: pass", ["other"]),
        ("def ratio(whole, part): pass", []),
        ("def places_in(self, other): pass", []),
        ("own, other = pair", []),
        ("print(found.at, f(one=1))", []),
    ],
)
def test_replaced_names_are_found_where_they_are_bound(tmp_path: Path, code: str, replaced: list[str]) -> None:
    path = tmp_path / "module.py"
    path.write_text(code, encoding="utf-8")
    assert sorted(offence.rule.split("'")[1] for offence in identifiers(path)) == sorted(replaced)
