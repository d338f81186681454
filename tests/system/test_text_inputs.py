"""Text from outside: any content of a file, an argument or a name is read, or rejected in one line."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from console.backends import processes
from console.connect import run_directory
from console.connect.run_directory import Address
from console.sweep import design
from fes.errors import FesError
from fes.protocol import channel_change
from fes.system import encoding
from fes.transport import identity
from tests.support.commands import call, complaint
from tests.support.paths import CONFIGS
from world.config import scenario
from world.config.scenario import parse_override

PAIR = (CONFIGS / "pair.toml").read_text(encoding="utf-8")
IN = ["--backend", "inprocess", "--headless", "--json", "--duration", "0.2"]

DEEP = {"lists": "[" * 20_000, "tables": "{a = " * 20_000, "closed": "[" * 300 + "]" * 300}
LONG = {"decimal": "1" * 5000, "hexadecimal": "0x" + "f" * 5000, "binary": "0b" + "1" * 20_000, "bits": str(2**64)}
"""Integers with too many digits for int(), for print() or for TOML."""


def line(run: Callable[[], object]) -> str:
    """Message of an error that a person can cause; empty without an error; raises any other error."""
    message = ""
    try:
        run()
    except FesError as error:
        message = str(error)
    assert "\n" not in message
    assert len(message) < 1000
    return message


def load(folder: Path, content: bytes) -> str:
    """The error about a scenario file with this content; empty if it is accepted."""
    path = folder / "some.toml"
    path.write_bytes(content)
    return line(lambda: scenario.load(path)).removeprefix(f"{path}: ")


# -- encodings


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + PAIR.encode(),
        PAIR.replace("\n", "\r\n").encode(),
        PAIR.replace("\n", "\r").encode(),
        b"\xef\xbb\xbf" + PAIR.replace("\n", "\r\n").encode(),
    ],
    ids=["mark", "CRLF", "CR", "mark and CRLF"],
)
def test_a_byte_order_mark_and_any_line_endings_are_accepted(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "pair.toml").write_bytes(content)
    assert scenario.load(tmp_path / "pair.toml") == scenario.load(CONFIGS / "pair.toml")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (PAIR.encode("utf-16"), "is UTF-16 text: save it as UTF-8"),
        (b"\xfe\xff" + PAIR.encode("utf-16-be"), "is UTF-16 text: save it as UTF-8"),
        (PAIR.encode("utf-32"), "is UTF-32 text: save it as UTF-8"),
        (PAIR.encode("utf-16-le"), "has zero bytes, as UTF-16 text or a binary file has: save it as UTF-8 text"),
        (b"# one\n# caf\xe9\n" + PAIR.encode(), "is not UTF-8, line 2 has the byte 0xe9: save it as UTF-8"),
    ],
    ids=["UTF-16", "UTF-16 BE", "UTF-32", "without a mark", "Latin-1"],
)
def test_another_encoding_is_named(content: bytes, said: str, tmp_path: Path) -> None:
    assert load(tmp_path, content) == said


def test_an_endless_file_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encoding, "LONGEST_FILE", 1 << 20)
    assert line(lambda: scenario.load(Path("/dev/zero"))) == "/dev/zero: is longer than 1 MiB"


# -- TOML


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_toml_that_is_nested_too_deeply_is_reported_in_one_line(text: str, tmp_path: Path) -> None:
    for message in (load(tmp_path, f"x = {text}".encode()), line(lambda: parse_override(f"run.dt={text}"))):
        assert message.endswith(("is nested too deeply", "expects one value, got"))


@pytest.mark.parametrize("text", LONG.values(), ids=LONG)
def test_an_integer_with_too_many_digits_is_rejected_in_one_line(text: str, tmp_path: Path) -> None:
    words = ("has a number or a date that is too large", " bits, more than 64")
    for message in (load(tmp_path, f"[run]\ndt = {text}".encode()), line(lambda: parse_override(f"run.dt={text}"))):
        assert any(word in message for word in words), message
    assert any(word in line(lambda: design.parse_axis(f"run.dt=0.1,{text}")) for word in words)


def test_a_key_through_too_many_tables_is_rejected_in_one_line(tmp_path: Path) -> None:
    path = ".".join("a" * 1000)
    assert "is nested too deeply" in load(tmp_path, f"{path} = 1".encode())
    words = ["run", str(CONFIGS / "pair.toml"), *IN, "--set", f"{path}=1"]
    message = complaint(call(tmp_path, "fes", *words), "fes")
    assert message.startswith("--set: expects a field within at most 100 tables, got 'a.a.a.")
    assert len(message) < 300


TEXTS = st.text(st.characters(codec="utf-8"), max_size=30)
SCRAPS = st.sampled_from(
    ["=", "[", "]", "{", "}", '"', "'''", "\n", ",", ".", "#", "schema = 1", "[run]", "dt", "[[event]]", "[[expect]]",
     "at = 1.0", "set = {", '"channel.', "of = ", '"time_to', "below", "1e999", "-0", "0x", "nan", "inf",
     "1979-05-27", "0001-01-01T00:00:00+23:59", "9" * 400, "9" * 4301, "\ufeff", "\x00", "\r",
     "poses = [[", "robots.count", "true"]
)  # fmt: skip
JUNK = st.lists(st.one_of(SCRAPS, TEXTS), max_size=12).map("".join)


@given(JUNK, st.integers(0, len(PAIR)))
def test_any_text_in_a_scenario_is_accepted_or_rejected_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, junk: str, at: int
) -> None:
    folder = tmp_path_factory.getbasetemp()
    load(folder, (PAIR[:at] + junk + PAIR[at:]).encode())
    load(folder, junk.encode())


@given(st.binary(max_size=80), st.integers(0, len(PAIR)))
def test_any_bytes_in_a_scenario_are_accepted_or_rejected_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, junk: bytes, at: int
) -> None:
    load(tmp_path_factory.getbasetemp(), PAIR.encode()[:at] + junk + PAIR.encode()[at:])


FIELDS = st.sampled_from(
    ["run.dt", "run.seed", "robots.poses", "event", "expect", "channel.jammers", "a", "run", "expect.of"]
)


@given(st.one_of(JUNK, st.builds("{}={}".format, FIELDS, JUNK), st.text(max_size=20)))
def test_any_override_axis_seeds_and_change_is_accepted_or_rejected_in_one_line(text: str) -> None:
    def set_() -> None:
        path, value = parse_override(text)
        scenario.load(CONFIGS / "pair.toml", {path: value})
        channel_change.encode_change(channel_change.ParameterChange(path, value))

    line(set_)
    line(lambda: design.parse_axis(text))
    line(lambda: design.parse_seeds(text))


@example(of="", equals="", settings={"\n": 1})
@given(
    of=TEXTS, equals=st.one_of(TEXTS, st.integers(), st.floats()), settings=st.dictionaries(TEXTS, JUNK, max_size=2)
)
def test_any_expectation_and_event_is_accepted_or_rejected_in_one_line(
    of: str, equals: object, settings: dict[str, Any]
) -> None:
    tables = {"schema": 1, "robots": {"count": 2}}
    line(lambda: scenario.parse({**tables, "expect": [{"of": of, "equals": equals}]}, "here"))
    line(lambda: scenario.parse({**tables, "event": [{"at": 1.0, "set": settings}]}, "here"))
    line(lambda: scenario.parse({**tables, "event": [{"at": 1.0, "set": {"channel." + of: settings}}]}, "here"))


# -- other files


JSON = ["", "[" * 100_000, "{" * 10, "1" * 5000, '"', "null", "[]", '{"endpoint": 3, "run": "main"}']


BOGUS = json.dumps(vars(Address("bogus", "main", os.getpid())))


@pytest.mark.parametrize("text", [*JSON, pytest.param(BOGUS, id="of no endpoint")])
def test_an_announcement_that_no_run_made_is_ignored(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs" / "one").mkdir(parents=True)
    (tmp_path / "runs" / "one" / run_directory.ENDPOINT).write_text(text)
    assert run_directory.announced("main") is None


@pytest.mark.parametrize("pid", [10**40, "1", None, True, -1])
def test_an_announcement_of_an_impossible_process_is_ignored(
    pid: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs" / "one").mkdir(parents=True)
    announcement = {"endpoint": "tcp/127.0.0.1:1", "run": "main", "pid": pid}
    (tmp_path / "runs" / "one" / run_directory.ENDPOINT).write_text(json.dumps(announcement))
    assert run_directory.announced("main") is None


@pytest.mark.parametrize("text", JSON[:5])
def test_a_summary_and_a_sweep_that_cannot_be_read_are_reported_in_one_line(text: str, tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text(text)
    assert line(lambda: processes.read_summary(tmp_path)) == f"{tmp_path} has no summary"
    (tmp_path / "summary.json").write_text("[1]")
    assert line(lambda: processes.read_summary(tmp_path)) == f"{tmp_path} has no summary"
    out = tmp_path / "sweep"
    out.mkdir()
    (out / "sweep.json").write_text(text)
    words = ["sweep", str(CONFIGS / "pair.toml"), "--seeds", "0:1", "--set", "run.duration=0.1", "--out", str(out)]
    assert f"{out / 'sweep.json'} cannot be read" in complaint(call(tmp_path, "fes", *words), "fes")


KEYS = {
    "empty": b"",
    "junk": b"\x00\xff" * 40,
    "UTF-16": "-----BEGIN CERTIFICATE-----".encode("utf-16"),
    "no end": b"-----BEGIN CERTIFICATE-----\nAAAA\n",
    "not base64": b"-----BEGIN CERTIFICATE-----\n????\n-----END CERTIFICATE-----\n",
    "not ASN.1": b"-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n",
}


@pytest.mark.parametrize("content", KEYS.values(), ids=KEYS)
def test_an_invalid_certificate_or_key_is_rejected_in_one_line(content: bytes, tmp_path: Path) -> None:
    assert call(tmp_path, "fes", "keys", "init").returncode == 0
    for name in ("ca.crt", "world.crt", "world.key"):
        path = tmp_path / "keys" / name
        valid = path.read_bytes()
        path.write_bytes(content)
        message = line(lambda: identity.security(tmp_path / "keys", identity.WORLD))
        assert "the certificate or key of the world is invalid" in message
        path.write_bytes(valid)
    assert line(lambda: identity.security(tmp_path / "keys", identity.WORLD)) == ""


@pytest.mark.parametrize("mark", [b"\xef\xbb\xbf", b"a comment\n"])
def test_a_certificate_may_begin_with_a_byte_order_mark(mark: bytes, tmp_path: Path) -> None:
    assert call(tmp_path, "fes", "keys", "init").returncode == 0
    path = tmp_path / "keys" / "world.crt"
    path.write_bytes(mark + path.read_bytes())
    assert line(lambda: identity.security(tmp_path / "keys", identity.WORLD)) == ""
