"""Data is text: brackets are brackets, and no text from a file or the network moves the cursor."""

import ast
import io
import logging
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from console import cli
from console.backends import inprocess
from console.dashboard import frame, summary
from console.doctor.command import table as findings
from console.doctor.finding import failed
from console.replay import log
from console.terminal import printing
from fes import process
from fes.errors import FesError
from fes.recording.writer.log_file import LogFile
from fes.system import output, signals
from tests.support import recordings
from tests.support.frames import a_history, a_report
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.source import PACKAGES, modules
from world.execution.recorder import Recorder

EVIL = "\x1b]0;PWNED\x07\x1b[2J[bold red]x[/] :smile: [/b]\r\n\x9b2J\u202e"
SHOWN = r"\x1b]0;PWNED\x07\x1b[2J[bold red]x[/] :smile: [/b]\r\n\x9b2J\u202e"
LONG = "x" * 250
ODD = "a[/b]c [red]d[ [lambda=2] :smile:"


def is_clean(text: str) -> bool:
    """True if a text has no control character except newlines."""
    return all(line.isprintable() for line in text.split("\n"))


def words(text: str) -> str:
    """A folded text as the single line before the folding."""
    return "".join(text.split())


def evil(value: Any) -> Any:
    """A summary in which every string is EVIL."""
    if isinstance(value, str):
        return EVIL
    if isinstance(value, dict):
        return {key: evil(inner) for key, inner in value.items()}
    return [evil(inner) for inner in value] if isinstance(value, list) else value


def fes(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Call the command in this process; returns its exit code."""
    monkeypatch.setattr(sys, "argv", ["fes", *arguments])
    with pytest.raises(SystemExit) as left:
        cli.main()
    return int(str(left.value.code))


def test_a_character_that_moves_the_cursor_is_shown_by_its_escape() -> None:
    assert output.printable(EVIL) == SHOWN
    assert output.printable("säule→\udcff") == r"säule→\udcff"


@pytest.mark.parametrize("verbose", [False, True])
def test_every_string_of_a_summary_is_text(verbose: bool, capfd: pytest.CaptureFixture[str]) -> None:
    expected = [{"of": "digest", "equals": "x"}]
    result = evil(inprocess.run(load("pair.toml", run__duration=1.0, expect=expected), "pair"))
    printing.show(printing.console(), summary.render(result, verbose))
    out = capfd.readouterr().out
    assert is_clean(out)
    assert r"\x1b]0;PWNED\x07\x1b[2J[boldred]x[/]" in words(out)


@pytest.fixture(scope="module")
def crafted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """An honest log, and a log with EVIL as name, backend and reason of its end, at an odd path."""
    where = tmp_path_factory.mktemp("a[b") / "[red]" / LONG
    where.mkdir(parents=True)
    pair = load("pair.toml", run__duration=0.2)
    recordings.record(where / "run.mcap", pair)

    def stop() -> None:
        with Recorder(where / "evil.mcap", pair, EVIL, EVIL, writer=LogFile) as recorder:
            recorder.conclude(inprocess.run(pair, EVIL, recorder=recorder) | {"backend": EVIL})
            raise FesError(EVIL)

    with pytest.raises(FesError):
        stop()
    return where / "run.mcap", where / "evil.mcap"


@pytest.mark.parametrize("way", ["replay", "all", "compare", "plot", "summary"])
def test_every_string_of_a_log_is_text_and_so_is_its_path(
    way: str,
    crafted: tuple[Path, Path],
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    honest, bad = crafted
    expected_text = SHOWN
    if way == "summary":  # a summary that differs from the ticks: the error quotes it
        true = log.load(honest).summary
        recordings.rewrite(honest, tmp_path / "other.mcap", lambda topic, tick, data: data, evil(true))
        code, arguments, expected_text = 1, ["replay", str(tmp_path / "other.mcap")], r"\x1b]0;PWNED\x07\x1b[2J"
    elif way == "plot":
        code, arguments, expected_text = (
            0,
            ["plot", str(honest), "--out", str(tmp_path / ODD)],
            f"{tmp_path / ODD}/formation.png",
        )
    elif way == "compare":
        code, arguments, expected_text = 1, ["compare", str(honest), str(bad)], r"\x1b]0;PWNED\x07\x1b[2J"
    else:
        code, arguments = 0, ["replay", str(bad), "--verbose", *(["--all"] if way == "all" else [])]
    assert fes(monkeypatch, *arguments) == code
    out, err = capfd.readouterr()
    assert is_clean(out + err)
    assert expected_text in out + err


def test_every_string_of_a_report_is_text_in_a_frame() -> None:
    screen = Console(width=300, height=40, file=io.StringIO())
    report = replace(a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)]), scenario=EVIL)
    screen.print(frame.render(a_history(report), 300, 40))
    assert isinstance(screen.file, io.StringIO)
    assert is_clean(screen.file.getvalue())
    assert SHOWN in screen.file.getvalue()


def test_findings_of_the_doctor_are_printed_as_text(capfd: pytest.CaptureFixture[str]) -> None:
    printing.show(printing.console(), findings([failed("endpoint", EVIL, EVIL)]))
    out = capfd.readouterr().out
    assert is_clean(out)
    assert words(SHOWN) in words(out)


def test_brackets_and_colons_are_text_on_every_console(capfd: pytest.CaptureFixture[str]) -> None:
    printing.console().print("[bold]x[/] [/b] :smile: \\[")
    assert capfd.readouterr().out == "[bold]x[/] [/b] :smile: \\[\n"


def test_an_error_and_a_line_of_a_log_are_one_line_of_text(capfd: pytest.CaptureFixture[str]) -> None:
    process.complain("fes", EVIL)
    record = logging.LogRecord("world", logging.INFO, "", 0, "summary: %s", (EVIL,), None)
    print(output.Formatter("%(message)s").format(record))
    out, err = capfd.readouterr()
    assert is_clean(out + err)
    assert out == f"summary: {SHOWN}\n"


def test_a_run_directory_is_printed_exactly_on_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a[red]b [lambda=2].toml").write_bytes(Path(PAIR).read_bytes())
    loop = ["--backend", "inprocess", "--duration", "0.2"]
    for out in (f"{ODD}/{LONG}", f"{LONG}/[/]"):
        assert fes(monkeypatch, "run", PAIR, *loop, "--out", out) == 0
        assert capfd.readouterr().out.splitlines()[-2] == f"run directory: {out}"
        assert (tmp_path / out / "summary.json").exists()
    assert fes(monkeypatch, "run", "a[red]b [lambda=2].toml", *loop) == 0
    out = capfd.readouterr().out
    assert out.splitlines()[-2] == "run directory: runs/a[red]b [lambda=2]-1"
    assert "a[red]b [lambda=2], 2 robots" in out
    fixed = ["--seeds", "0:2", "--set", "run.duration=0.2", "--jobs", "1", "--plot"]
    assert fes(monkeypatch, "sweep", "a[red]b [lambda=2].toml", *fixed, "--out", ODD + LONG[:200]) == 0
    out = capfd.readouterr().out
    assert f"\n{ODD + LONG[:200]}/table.csv\n" in out


def test_a_figure_does_not_read_a_name_as_a_formula(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a$\\frac$.toml").write_bytes(Path(PAIR).read_bytes())
    fixed = ["--seeds", "0:2", "--set", "run.duration=0.2", "--jobs", "1", "--plot", "--out", "out"]
    assert fes(monkeypatch, "sweep", "a$\\frac$.toml", *fixed) == 0
    assert (tmp_path / "out" / "sweep.svg").exists()


def test_only_one_module_makes_consoles_and_one_takes_the_screen_and_lines_are_printed_by_one_function() -> None:
    """In the others `print` gets JSON, which has no control characters."""
    makers: dict[str, set[str]] = {"Console": set(), "Live": set(), "print": set()}
    for name, path in modules(*PACKAGES).items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in makers):
                continue
            what = ast.unparse(node.args[0]) if node.args else ""
            if node.func.id != "print" or not what.startswith("strict_json.dumps("):
                makers[node.func.id].add(name)
    assert makers["Console"] == {
        "console.terminal.printing",
        "console.dashboard.live",
    }  # the latter on paper, for a picture
    assert makers["Live"] - {"world.server.server"} == {"console.terminal.screen"}  # the world's Live is a clock
    assert makers["print"] == {"console.terminal.printing", "fes.transport.health", "fes.process"}


def test_a_message_for_a_closed_standard_error_does_not_end_up_in_the_output(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stderr", None)
    for words in (["--no-such-flag"], []):  # a complaint, and the help
        monkeypatch.setattr(sys, "argv", ["fes", *words])
        with signals.restored(), pytest.raises(SystemExit) as ended:
            cli.main()
        assert ended.value.code == 1
    assert capsys.readouterr().out == ""
