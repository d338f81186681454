"""Identity of a process: the certificate of its role in a directory of keys, and Zenoh's settings for it.

| role        | who                                             | file beside ca.crt     |
|-------------|-------------------------------------------------|------------------------|
| world       | the world; the only one that may serve          | world.{crt,key}        |
| robot-<ids> | an agent, of robot 3 or of the crew 0-4         | robot-3.{crt,key}      |
| observer    | a program that watches a run                    | observer.{crt,key}     |
| operator    | an observer that may change the channel         | operator.{crt,key}     |
"""

import logging
import re
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from fes.errors import FesError
from fes.protocol import keys
from fes.system.distribution import install

WORLD, OBSERVER, OPERATOR = "world", "observer", "operator"
AUTHORITY = "ca"
"""Name of the files of the authority that issues all certificates of a run."""

_NOT_FOR_OTHERS = stat.S_IRWXO | stat.S_IWGRP

_logger = logging.getLogger("network")

_ROBOT = re.compile(r"robot-(0|[1-9][0-9]{0,9})(?:-([1-9][0-9]{0,9}))?")


def robot_role(robots: Sequence[int]) -> str:
    """The role of the agent that hosts these robots.

    >>> robot_role([3]), robot_role([0, 1, 2])
    ('robot-3', 'robot-0-2')
    """
    return f"robot-{keys.span(robots)}"


def robots_of(role: str) -> range | None:
    """The robots of an agent's role, or None for another role.

    >>> robots_of("robot-3"), robots_of("robot-0-2"), robots_of("observer")
    (range(3, 4), range(0, 3), None)
    """
    match = _ROBOT.fullmatch(role)
    if match is None:
        return None
    first, last = int(match[1]), int(match[2] or match[1])
    return range(first, last + 1) if match[2] is None or first < last else None


def check_role(role: str) -> str:
    """`role` itself, if there is such a role; raises FesError."""
    robots = robots_of(role)
    if robots is None and role not in (WORLD, OBSERVER, OPERATOR):
        raise FesError(f"a role is world, observer, operator, robot-I or robot-A-B, got '{role}'")
    if robots is not None and robots.stop > keys.MAX_ROBOTS:
        raise FesError(f"a run has robots 0 to {keys.MAX_ROBOTS - 1} at most, got '{role}'")
    return role


def crews(directory: Path) -> list[range]:
    """The crews of several robots that have a certificate in `directory`."""
    crews = (robots_of(path.stem) for path in directory.glob("robot-*-*.crt"))
    return sorted((crew for crew in crews if crew is not None), key=lambda crew: (crew.start, crew.stop))


@dataclass(frozen=True)
class Identity:
    """A role, with its certificate in a directory."""

    directory: Path
    role: str

    @property
    def certificate(self) -> Path:
        """The file of its certificate."""
        return self.directory / f"{self.role}.crt"

    @property
    def key(self) -> Path:
        """The file of its private key."""
        return self.directory / f"{self.role}.key"

    @property
    def authority(self) -> Path:
        """The file of the authority's certificate."""
        return self.directory / f"{AUTHORITY}.crt"

    def check(self) -> None:
        """Raise FesError if its certificate is missing, invalid, expired, or of another issuer, name or key."""
        for path in (self.authority, self.certificate, self.key):
            if not path.is_file():
                raise FesError(f"--keys {self.directory}: the {self.role} needs {path.name}, and there is none")
        try:
            from cryptography import x509
            from cryptography.exceptions import InvalidSignature
            from cryptography.hazmat.primitives.serialization import load_pem_private_key
            from cryptography.x509.oid import NameOID
        except ImportError:
            raise missing_extra() from None
        try:
            authority = x509.load_pem_x509_certificate(self.authority.read_bytes())
            certificate = x509.load_pem_x509_certificate(self.certificate.read_bytes())
            of_key = load_pem_private_key(self.key.read_bytes(), password=None).public_key()
        except (ValueError, TypeError) as error:
            raise FesError(
                f"{self.directory}: the certificate or key of the {self.role} is invalid: {error}"
            ) from None
        if of_key != certificate.public_key():
            raise FesError(f"{self.key}: is not the key of {self.certificate.name}")
        try:
            certificate.verify_directly_issued_by(authority)
        except (ValueError, TypeError, InvalidSignature):
            raise FesError(f"{self.certificate}: was not issued by {self.authority.name} beside it") from None
        names = [name.value for name in certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)]
        if names != [self.role]:  # the world's access rules refer to this name
            raise FesError(f"{self.certificate}: is that of '{', '.join(map(str, names))}', not of '{self.role}'")
        now = datetime.now(UTC)
        for path, checked in ((self.authority, authority), (self.certificate, certificate)):
            if now > checked.not_valid_after_utc:
                ended = checked.not_valid_after_utc
                raise FesError(f"{path}: the certificate expired on {ended:%Y-%m-%d %H:%M} UTC")
            if now < checked.not_valid_before_utc:
                begins = checked.not_valid_before_utc
                raise FesError(f"{path}: the certificate is valid only from {begins:%Y-%m-%d %H:%M} UTC")

    def settings(self) -> dict[str, object]:
        """Zenoh's settings, by its key: TLS only, and both ends show a certificate."""
        tls: dict[str, object] = {
            "root_ca_certificate": str(self.authority.resolve()),
            "enable_mtls": True,
            "verify_name_on_connect": True,
            "close_link_on_expiration": True,
            "connect_certificate": str(self.certificate.resolve()),
            "connect_private_key": str(self.key.resolve()),
        }
        if self.role == WORLD:
            tls["listen_certificate"] = tls["connect_certificate"]
            tls["listen_private_key"] = tls["connect_private_key"]
        return {"transport/link/protocols": ["tls"], "transport/link/tls": tls}


def security(directory: Path | None, role: str) -> dict[str, object]:
    """Zenoh's settings for a role with a certificate in `directory`; empty without one. Raises FesError."""
    if directory is None:
        return {}
    own = Identity(directory, role)
    own.check()
    warn_if_open(own.key)
    return own.settings()


def warn_if_open(key: Path) -> None:
    """Log a private key that others on this machine can read or change; an owner's group may read it."""
    mode = stat.S_IMODE(key.stat().st_mode)
    if mode & _NOT_FOR_OTHERS:
        _logger.warning("%s: others on this machine can read or change it (mode %04o): chmod 600 %s", key, mode, key)


def missing_extra() -> FesError:
    """The error of an installation that cannot read certificates."""
    return FesError(f"certificates need cryptography: {install('security')}")
