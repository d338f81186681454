"""Directories of real certificates, good and bad."""

from pathlib import Path

from console.keys import certificates
from console.keys.certificates import Authority, Issued
from fes.transport.identity import AUTHORITY, Identity


def write(directory: Path, role: str, issued: Issued) -> None:
    directory.mkdir(exist_ok=True)
    (directory / f"{role}.crt").write_bytes(issued.certificate)
    (directory / f"{role}.key").write_bytes(issued.key)
    (directory / f"{role}.key").chmod(0o600)


def directory(where: Path, issuer: Authority, roles: list[str], days: float = 1.0) -> Path:
    """A directory with the certificates of `roles` and of their authority."""
    write(where, AUTHORITY, issuer.pem)
    for role in roles:
        write(where, role, certificates.issue(issuer, role, days))
    return where


def security(where: Path, role: str) -> dict[str, object]:
    """Zenoh's settings for a role, without a check of its certificate, as an attacker uses them."""
    return Identity(where, role).settings()
