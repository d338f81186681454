"""Message types described for readers that do not know them: the FileDescriptorSet of Protocol Buffers."""

from typing import Any

from fes.recording.protobuf import SCALARS, Field, Message, Types, parse

_MESSAGE, _ENUM, _OPTIONAL, _REPEATED = 11, 14, 1, 3


def describe(message: Message) -> bytes:
    """The binary FileDescriptorSet of a type and of all that it is made of."""
    packages: dict[str, list[Message]] = {}
    for part in _parts(message, {}):
        packages.setdefault(part.name.rpartition(".")[0], []).append(part)
    described = [_file(package, packages) for package in sorted(packages, key=lambda package: "." not in package)]
    return _DESCRIPTORS["FileDescriptorSet"].encode({"file": described})


def _parts(message: Message, seen: Types) -> list[Message]:
    """The message and every other that it is made of, each once."""
    if message.name not in seen:
        seen[message.name] = message
        for field in message.fields.values():
            if field.message is not None:
                _parts(field.message, seen)
    return list(seen.values())


def _file(package: str, packages: dict[str, list[Message]]) -> dict[str, Any]:
    """The descriptor of a package; packages with a dot in their name are others' and stand alone."""
    others = [] if "." in package else [other for other in packages if "." in other]
    return {
        "name": _file_name(package),
        "package": package,
        "dependency": [_file_name(other) for other in others],
        "message_type": [_message(message) for message in packages[package]],
        "syntax": "proto3",
    }


def _file_name(package: str) -> str:
    return package.replace(".", "/") + ".proto"


def _message(message: Message) -> dict[str, Any]:
    return {
        "name": message.name.rpartition(".")[2],
        "field": [_field(message, field) for field in message.fields.values()],
        "enum_type": [
            {"name": name, "value": [{"name": one, "number": number} for one, number in values]}
            for name, values in message.enums.items()
        ],
    }


def _field(message: Message, field: Field) -> dict[str, Any]:
    described = {
        "name": field.name,
        "number": field.number,
        "label": _REPEATED if field.repeated else _OPTIONAL,
        "type": _ENUM if field.enum else SCALARS.get(field.kind, _MESSAGE),
    }
    if field.enum:
        described["type_name"] = f".{message.name}.{field.kind}"
    elif field.message is not None:
        described["type_name"] = f".{field.message.name}"
    return described


_DESCRIPTORS = parse(
    "",
    """
    message FileDescriptorSet { repeated FileDescriptorProto file = 1; }
    message FileDescriptorProto {
      string name = 1; string package = 2; repeated string dependency = 3; repeated DescriptorProto message_type = 4;
      string syntax = 12;
    }
    message DescriptorProto {
      string name = 1; repeated FieldDescriptorProto field = 2; repeated EnumDescriptorProto enum_type = 4;
    }
    message EnumDescriptorProto { string name = 1; repeated EnumValueDescriptorProto value = 2; }
    message EnumValueDescriptorProto { string name = 1; int32 number = 2; }
    message FieldDescriptorProto {
      string name = 1; int32 number = 3; int32 label = 4; int32 type = 5; string type_name = 6;
    }
    """,
)
