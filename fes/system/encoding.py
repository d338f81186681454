"""Text from outside: files, arguments and names of files, which may be in any encoding, and of any length.

Everything that a person writes passes one of these functions before a parser sees it. Their
ValueError states a rule in one line; the caller adds the place.
"""

import codecs
import os
from pathlib import Path

from fes.errors import FesError

LONGEST_FILE = 1 << 26
"""Longest text file that is read [bytes]; a scenario with 100,000 poses has a tenth of that."""

LONGEST_NAME = 255
"""Longest name of a scenario [characters], the same as that of a file."""

DEEPEST = 100
"""Largest depth of tables and lists within each other; a scenario has five."""

MOST_OPEN = 1000
"""Largest depth of brackets that a parser in C or Rust is given: at 20,000 Zenoh's ends the process."""

_OTHERS = (
    (codecs.BOM_UTF32_LE, "UTF-32"),
    (codecs.BOM_UTF32_BE, "UTF-32"),
    (codecs.BOM_UTF16_LE, "UTF-16"),
    (codecs.BOM_UTF16_BE, "UTF-16"),
)
"""Byte order marks of other encodings, the longer ones first: UTF-32's begins with that of UTF-16."""


def read(path: Path) -> str:
    """The text of a file, by `decode`; raises OSError if it cannot be read, and ValueError if it is not text."""
    with path.open("rb") as file:
        data = file.read(LONGEST_FILE + 1)
    if len(data) > LONGEST_FILE:
        raise ValueError(f"is longer than {LONGEST_FILE >> 20} MiB")
    return decode(data)


def decode(data: bytes) -> str:
    """The text in UTF-8 bytes, without a byte order mark, lines ended by newlines; raises ValueError.

    >>> decode(codecs.BOM_UTF8 + b"schema = 1\\r\\n")
    'schema = 1\\n'
    """
    for mark, name in _OTHERS:
        if data.startswith(mark):
            raise ValueError(f"is {name} text: save it as UTF-8")
    if b"\0" in data:
        raise ValueError("has zero bytes, as UTF-16 text or a binary file has: save it as UTF-8 text")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = 1 + error.object.count(b"\n", 0, error.start)
        byte = error.object[error.start]
        raise ValueError(f"is not UTF-8, line {line} has the byte 0x{byte:02x}: save it as UTF-8") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def check_depth(text: str) -> None:
    """Raise ValueError for text with more than MOST_OPEN brackets within each other.

    Some parsers end the process on them. Brackets in strings and comments count too.
    """
    depth = 0
    for letter in text:
        if letter in "[{":
            depth += 1
            if depth > MOST_OPEN:
                raise ValueError(f"has more than {MOST_OPEN} brackets within each other")
        elif letter in "]}":
            depth = max(0, depth - 1)


def argument(text: str) -> str:
    """An argument or a name of a file as text in UTF-8, in any locale.

    Python turns bytes that its locale cannot read into lone surrogates, which cannot be written in UTF-8. Here bytes
    that are UTF-8 become characters; others become U+FFFD.

    >>> argument("caf\\udcc3\\udca9"), argument("caf\\udce9")
    ('café', 'caf\ufffd')
    """
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def file_name(text: str) -> str:
    """Valid text as the name of a file: in UTF-8 even if the locale cannot encode it.

    >>> file_name("pair")
    'pair'
    """
    return os.fsdecode(as_bytes(text))


def as_bytes(text: str) -> bytes:
    """An argument of a process or a name of a file in bytes: in UTF-8 if the locale cannot encode it."""
    try:
        return os.fsencode(text)
    except UnicodeEncodeError:
        return text.encode("utf-8", "surrogateescape")


def name_of(path: Path) -> str:
    """The name of a scenario, taken from its file: valid text that can be printed.

    >>> name_of(Path("configs/pair.toml")), name_of(Path("a\\x1b[2J\\udcff.toml"))
    ('pair', 'a?[2J\ufffd')
    """
    return check_name(path.stem)


def check_name(name: str) -> str:
    """The name of a scenario as valid text that can be printed; raises FesError if it is too long."""
    shown = "".join(letter if letter.isprintable() else "?" for letter in argument(name))
    if len(shown) > LONGEST_NAME:
        raise FesError(f"the name of a scenario has at most {LONGEST_NAME} characters, got {len(shown)}")
    return shown
