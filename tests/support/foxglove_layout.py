"""The topics and fields that the layout for Foxglove and Lichtblick names."""

from collections.abc import Iterator, Mapping
from typing import Any

from google.protobuf.message import Message

from console.foxglove.server import LAYOUT
from fes.system import strict_json


def layout() -> dict[str, Any]:
    table: dict[str, Any] = strict_json.loads(LAYOUT.read_text(encoding="utf-8"))
    return table


def message_paths() -> list[str]:
    """Each topic, or topic and field, in the layout: every text that begins with a slash."""
    return sorted(set(_texts(layout())))


def unknown(kinds: Mapping[str, type[Message]]) -> list[str]:
    """The message paths of the layout whose topic or field does not exist, given the type of each topic."""
    return [path for path in message_paths() if not _exists(path, kinds)]


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key, content in value.items():
            yield from _texts(key)
            yield from _texts(content)
    elif isinstance(value, list):
        for content in value:
            yield from _texts(content)
    elif isinstance(value, str) and value.startswith("/"):
        yield value


def _exists(path: str, kinds: Mapping[str, type[Message]]) -> bool:
    topic, *names = path.split(".")
    if topic not in kinds:
        return False
    descriptor = kinds[topic].DESCRIPTOR
    for name in names:
        if descriptor is None or name not in descriptor.fields_by_name:
            return False
        descriptor = descriptor.fields_by_name[name].message_type
    return True
