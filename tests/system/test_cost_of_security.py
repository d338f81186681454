"""The cost of certificates in docs/explanation/security.md, measured again for the team that it names."""

import json
import re
import subprocess
from typing import Any

import pytest

from bench.speed import secure
from tests.support.paths import CONFIGS, DOCS

TEXT = (DOCS / "explanation" / "security.md").read_text(encoding="utf-8")


def test_the_bench_measures_the_requested_team(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run, seen = subprocess.run, []

    def watched(words: list[str], **settings: Any) -> Any:
        done = run(words, **settings)
        seen.append(({"--secure"} <= set(words), settings["env"].get("RUST_LOG") == "off", json.loads(done.stdout)))
        return done

    monkeypatch.setattr(subprocess, "run", watched)
    words = [str(CONFIGS / "hundred.toml"), "--agents-per-process", "50", "--duration", "0.2", "--rounds", "1"]
    secure.main(words)
    assert [(tls, silent) for tls, silent, _ in seen] == [(False, False), (True, False), (True, True)]
    assert {(result["robots"], result["ticks"]) for *_, result in seen} == {(100, 10)}
    assert len({result["digest"] for *_, result in seen}) == 1
    title, figures, *medians = capsys.readouterr().out.splitlines()
    assert title == "secure: hundred.toml, 0.2 s, 100 robots in 2 processes"
    # On a slow machine a rate may have one digit, and more spaces before it.
    assert [kind.strip() for kind in re.findall(r"([a-z, ]+?) +\d+ ticks/s", figures)] == list(secure.KINDS)
    assert [line.split("/")[0].strip() for line in medians] == ["median secure", "median secure, no audit"]


def test_the_bench_accepts_the_command_of_the_docs(monkeypatch: pytest.MonkeyPatch) -> None:
    [flags] = re.findall(r"python -m bench\.speed\.secure (configs/[^`]+)`", TEXT.replace("\n", " "))
    asked = []

    def measured(words: list[str], audit: bool) -> tuple[float, float]:
        asked.append(words)
        return 1.0, 1.0

    monkeypatch.setattr(secure, "measure", measured)
    monkeypatch.chdir(CONFIGS.parent)
    secure.main([*flags.split(), "--rounds", "1"])
    assert len(asked) == len(secure.KINDS)
    for words in asked:
        assert words[0] == "configs/hundred.toml"
        assert words[words.index("--agents-per-process") + 1] == "25"
