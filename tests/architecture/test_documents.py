"""The pages: generated ones are current, fenced blocks are marked, links lead to files that exist."""

import re
from pathlib import Path

import pytest

from docs import generate
from docs.generators import messages
from tests.support import fences
from tests.support.paths import DOCS, ROOT, tracked

LONGEST_README = 150
LANGUAGES = {"sh", "console", "text", "toml", "python"}
NAMING = ("compose.yaml", "deploy", "tests", "fes", "agents", "world", "field", "console", "bench")
"""Folders and files whose comments name pages."""

LINKED = [*fences.PAGES, ROOT / "CHANGELOG.md", ROOT / "SECURITY.md"]


@pytest.mark.parametrize("page", generate.pages(), ids=lambda path: path.stem)
def test_a_generated_page_is_current(page: Path) -> None:
    assert page.read_text(encoding="utf-8") == generate.pages()[page], "run python -m docs.generate"


def test_the_page_of_the_messages_has_every_payload_of_the_table_of_keys() -> None:
    text = (DOCS / "reference" / "messages-and-keys.md").read_text(encoding="utf-8")
    assert messages.names() <= set(re.findall(r"^### (\w+)$", text, re.MULTILINE)) | {"Lease", "Recall"}


def test_no_file_has_the_marks_of_an_unfinished_merge() -> None:
    marks = re.compile(r"^(<{7}|>{7}) ", re.MULTILINE)
    texts = {path: path.read_text(encoding="utf-8", errors="replace") for path in tracked()}
    assert ROOT / "CHANGELOG.md" in texts
    assert [path for path, text in texts.items() if marks.search(text)] == []


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= LONGEST_README


@pytest.mark.parametrize("page", fences.PAGES, ids=lambda path: path.stem)
def test_every_fenced_block_of_a_program_is_run_by_a_test_or_states_why_not(page: Path) -> None:
    for block in fences.blocks(page):
        assert block.language in LANGUAGES, f"line {block.line}: a block names its language"
        if block.language in ("sh", "python"):
            stated = fences.NOT_RUN.fullmatch(block.mark) or fences.FILE.fullmatch(block.mark)
            known = block.mark in (fences.RUN, *fences.BY_SCRIPTS) or stated
            assert known, f"line {block.line}: needs <!-- run -->, <!-- file: name --> or <!-- not run: reason -->"


def test_the_law_of_the_tutorial_is_that_of_the_example() -> None:
    files = {block.mark: block.text for block in fences.blocks(DOCS / "tutorial" / "own-law.md")}
    example = ROOT / "examples" / "own-law"
    assert files["file: own_law.py"] == (example / "own_law.py").read_text(encoding="utf-8")
    project = (example / "pyproject.toml").read_text(encoding="utf-8")
    assert project in (DOCS / "tutorial" / "own-law.md").read_text(encoding="utf-8")


def test_the_blocks_that_scripts_run_are_in_the_readme_once() -> None:
    marks = [block.mark for page in fences.PAGES for block in fences.shell(page) if block.mark in fences.BY_SCRIPTS]
    assert sorted(marks) == sorted(fences.BY_SCRIPTS)


@pytest.mark.parametrize("page", LINKED, ids=lambda path: path.stem)
def test_every_link_to_a_file_leads_to_one(page: Path) -> None:
    text = re.sub(r"`[^`\n]*`|<!--.*?-->", "", page.read_text(encoding="utf-8"))
    targets = re.findall(r"\]\(([^)#\s]+)[^)]*\)", text)
    missing = [target for target in targets if "://" not in target and not (page.parent / target).exists()]
    assert not missing


def test_the_navigation_of_the_site_has_every_page_once() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    pages = re.findall(r": (\S+\.md)$", navigation, re.MULTILINE)
    assert sorted(pages) == sorted(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md"))


@pytest.mark.parametrize("folder", NAMING)
def test_every_page_that_a_comment_or_a_docstring_names_exists(folder: str) -> None:
    top = ROOT / folder
    for path in [top] if top.is_file() else sorted(top.rglob("*")):
        if path.suffix in (".py", ".service", ".yaml", ".md"):
            named = re.findall(r"\bdocs/[\w/-]+\.md\b", path.read_text(encoding="utf-8"))
            missing = [name for name in named if not (ROOT / name).exists()]
            assert not missing, path
