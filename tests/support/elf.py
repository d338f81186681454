"""The dynamic symbols of a shared library in the format ELF, 64 bits, lowest byte first."""

import struct
from pathlib import Path
from typing import NamedTuple

MAGIC = b"\x7fELF\x02\x01"
_DYNAMIC_SYMBOLS = 11
"""Type of the section of dynamic symbols."""


class Symbols(NamedTuple):
    """The names that a library gives and takes."""

    exported: set[str]
    imported: set[str]


def symbols(path: Path) -> Symbols:
    """The dynamic symbols of a library; raises ValueError for another format."""
    data = path.read_bytes()
    if not data.startswith(MAGIC):
        raise ValueError(f"not an ELF file of 64 bits: {path}")
    table, entry, count = struct.unpack_from("<Q", data, 40)[0], *struct.unpack_from("<HH", data, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, table + entry * index) for index in range(count)]
    exported, imported = set[str](), set[str]()
    for _, kind, _, _, offset, size, link, *_ in sections:
        if kind != _DYNAMIC_SYMBOLS:
            continue
        names = sections[link][4]
        for place in range(offset, offset + size, 24):
            name, _, _, section = struct.unpack_from("<IBBH", data, place)
            text = data[names + name : data.index(b"\0", names + name)].decode()
            if text:
                (exported if section else imported).add(text)
    return Symbols(exported, imported)
