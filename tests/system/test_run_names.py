"""Names of scenarios and texts of arguments: valid text from the entry point on, in every locale."""

import ast
import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from console.sweep import design
from fes.system import encoding
from fes.system.distribution import PACKAGES
from tests.support.commands import PROGRAMS, call, complaint
from tests.support.paths import CONFIGS, ROOT

PAIR = (CONFIGS / "pair.toml").read_text(encoding="utf-8")
IN = ["--backend", "inprocess", "--headless", "--json", "--duration", "0.2"]


NAMES = {b"bad\xff": "bad\ufffd", "caf\u00e9".encode(): "caf\u00e9", b"a\x1b[2J\nb": "a?[2J?b", b"n" * 250: "n" * 250}
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def fes(where: Path, locale: dict[str, str], *words: str | bytes) -> dict[str, Any]:
    """The JSON output of a command that ends well."""
    command = [bytes(PROGRAMS / "fes"), *words]
    done = subprocess.run(command, cwd=where, env={**os.environ, **locale}, capture_output=True, timeout=90)
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


@pytest.mark.parametrize(("name", "shown"), NAMES.items(), ids=["bytes", "letters", "escapes", "long"])
def test_any_file_name_yields_a_valid_name_of_a_run(name: bytes, shown: str, tmp_path: Path) -> None:
    (tmp_path / os.fsdecode(name + b".toml")).write_text(PAIR, encoding="utf-8")
    assert fes(tmp_path, ASCII, "run", name + b".toml", *IN, "--out", "run")["scenario"] == shown
    assert fes(tmp_path, ASCII, "replay", "run", "--json")["scenario"] == shown


@pytest.mark.parametrize("locale", [{}, ASCII], ids=["UTF-8", "ASCII"])
def test_processes_receive_the_name_of_a_run_in_any_locale(locale: dict[str, str], tmp_path: Path) -> None:
    for number, (name, shown) in enumerate(list(NAMES.items())[:2]):
        (tmp_path / os.fsdecode(name + b".toml")).write_text(PAIR, encoding="utf-8")
        words = [*IN[2:], "--agents-per-process", "2", "--out", str(number)]
        assert fes(tmp_path, locale, "run", name + b".toml", *words)["scenario"] == shown


def test_a_sweep_accepts_any_file_name(tmp_path: Path) -> None:
    for name, shown in NAMES.items():
        (tmp_path / os.fsdecode(name + b".toml")).write_text(PAIR, encoding="utf-8")
        planned = design.plan(tmp_path / os.fsdecode(name + b".toml"), [], "0:1", [])
        assert planned.name == shown


def test_a_given_name_is_bounded_like_a_file_name(tmp_path: Path) -> None:
    done = call(tmp_path, "fes-world", str(CONFIGS / "pair.toml"), "--name", "n" * 256)
    assert complaint(done, "fes-world") == "the name of a scenario has at most 255 characters, got 256"


def test_an_argument_in_utf_8_is_read_in_any_locale() -> None:
    for text in ("caf\u00e9", "\u4e16\u754c"):
        garbled = text.encode().decode("ascii", "surrogateescape")
        assert encoding.argument(garbled) == encoding.argument(text) == text
        assert os.fsencode(encoding.file_name(text)) == text.encode()


def test_no_text_file_is_read_or_written_in_the_encoding_of_the_locale() -> None:
    texts = {"read_text", "write_text"}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in texts:
                    given = {word.arg for word in node.keywords}
                    assert "encoding" in given, f"{path}: line {node.lineno}"


@pytest.mark.parametrize(
    "words",
    [
        ["fes-agent", "--id", "0", "--run"],
        ["fes-world", str(CONFIGS / "pair.toml"), "--run"],
        ["fes", "view", "--run"],
        ["fes", "set", "channel.reference_snr=1", "--run"],
        ["fes", "doctor", "--run"],
        ["fes", "keys", "rules", "--robots", "1", "--run"],
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_every_program_rejects_a_run_name_that_would_make_keys_too_long(words: list[str], tmp_path: Path) -> None:
    if "keys" in words:
        assert call(tmp_path, "fes", "keys", "init").returncode == 0
    done = call(tmp_path, *words, "r" * 70_000)
    assert done.returncode == 1
    assert "a run's name is 1 to 64 letters" in done.stdout + done.stderr
