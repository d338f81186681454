"""Outputs of `tests.portability.digests`, compared with those of the first setting."""

from dataclasses import dataclass
from pathlib import Path

CONTROLS = ("loops", "libm", "blas")
"""Hashes that a setting should change."""


@dataclass(frozen=True)
class Output:
    """The lines of a process."""

    about: dict[str, str]
    """Name -> value of its lines about itself."""
    lines: dict[str, dict[str, str]]
    """Case -> part -> hash."""

    @staticmethod
    def read(path: Path) -> "Output":
        """The output in a file; lines of another form are ignored."""
        about: dict[str, str] = {}
        lines: dict[str, dict[str, str]] = {}
        for line in path.read_text().splitlines():
            name, *rest = line.split()
            if name == "#" and ": " in line:
                key, _, value = line[2:].partition(": ")
                about[key] = value
            elif len(rest) == 4 and all("=" in word for word in rest[1:]):
                lines[name] = {"digest": rest[0], **dict(word.split("=", 1) for word in rest[1:])}
        return Output(about, lines)

    def effect(self, base: "Output") -> str:
        """Lost features, and controls with other bits: the proof that a setting does something."""
        lost = [word for word in base.about["features"].split() if word not in self.about["features"].split()]
        if self.about["numpy"] != base.about["numpy"] or self.about["machine"] != base.about["machine"]:
            lost = []  # their names differ
        changed = [name for name in CONTROLS if self.about[name] != base.about[name]]
        took = f"takes away {' '.join(lost)}, " if lost else ""
        return took + (f"changes the bits of {', '.join(changed)}" if changed else "changes no bits of the controls")

    def unlike(self, digests: dict[str, str]) -> list[str]:
        """Cases of which the digest is another one than the given one, and given ones that are not here."""
        found = {name: parts["digest"] for name, parts in self.lines.items()}
        return sorted(name for name in found | digests if found.get(name) != digests.get(name))

    def differences(self, base: "Output") -> list[str]:
        """Cases of this output that are not in `base` or differ there, with the parts that differ."""
        found = [] if self.lines else ["no case at all"]
        for name, parts in self.lines.items():
            if (others := base.lines.get(name)) is None:
                found.append(f"{name} (not in the first setting)")
            elif unequal := [part for part, value in parts.items() if others.get(part) != value]:
                found.append(f"{name} ({', '.join(unequal)})")
        return found
