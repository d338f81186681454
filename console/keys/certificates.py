"""Certificates: an authority, and the certificates that it issues. Independent of runs and of Zenoh."""

import ipaddress
import re
import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from fes.errors import FesError
from fes.transport.identity import AUTHORITY, WORLD

OWN_HOSTS = ("localhost", "127.0.0.1")
"""Names of every world in its certificate."""

_LABEL = "[A-Za-z0-9_]([A-Za-z0-9_-]{0,61}[A-Za-z0-9_])?"
_NAME = re.compile(rf"(?=.{{1,253}}$)({_LABEL}\.)*(?![0-9]+$){_LABEL}")
"""A domain name. Its last label is never a number, which would make it an address."""

SKEW = timedelta(minutes=5)
"""Certificates are valid from this long before their creation, because clocks of other machines may lag."""


@dataclass(frozen=True)
class Issued:
    """A certificate and its private key, in PEM."""

    certificate: bytes
    key: bytes


@dataclass(frozen=True)
class Authority:
    """The authority that signs the certificates of a run."""

    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    @property
    def pem(self) -> Issued:
        """Its own certificate and private key."""
        return Issued(self.certificate.public_bytes(serialization.Encoding.PEM), _pem(self.key))


def create(days: float) -> Authority:
    """A new authority, valid for `days`."""
    key = ec.generate_private_key(ec.SECP256R1())
    # Two authorities of the same name would differ only in the signature.
    name = _name(f"fes authority {secrets.token_hex(4)}")
    constraints = x509.BasicConstraints(ca=True, path_length=0)
    usage = _usage(signs_certificates=True)
    identifier = x509.SubjectKeyIdentifier.from_public_key(key.public_key())
    builder = (
        _dated(days)
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .add_extension(constraints, critical=True)
        .add_extension(usage, critical=True)
        .add_extension(identifier, critical=False)
    )
    return Authority(builder.sign(key, hashes.SHA256()), key)


def restore(issued: Issued) -> Authority:
    """The authority with this certificate and private key; raises ValueError."""
    key = serialization.load_pem_private_key(issued.key, password=None)
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise ValueError("not an elliptic-curve key")
    return Authority(x509.load_pem_x509_certificate(issued.certificate), key)


def issue(authority: Authority, role: str, days: float, hosts: tuple[str, ...] = ()) -> Issued:
    """A certificate with a role as common name. The world's is also for a server, at `hosts` and OWN_HOSTS."""
    key = ec.generate_private_key(ec.SECP256R1())
    purposes = [ExtendedKeyUsageOID.CLIENT_AUTH]
    if role == WORLD:
        purposes.insert(0, ExtendedKeyUsageOID.SERVER_AUTH)
    signer = x509.AuthorityKeyIdentifier.from_issuer_public_key(authority.key.public_key())
    builder = (
        _dated(days)
        .subject_name(_name(role))
        .issuer_name(authority.certificate.subject)
        .public_key(key.public_key())
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_usage(signs_certificates=False), critical=True)
        .add_extension(x509.ExtendedKeyUsage(purposes), critical=False)
        .add_extension(signer, critical=False)
    )
    if role == WORLD:
        names = [_host(host) for host in dict.fromkeys((*OWN_HOSTS, *hosts))]
        builder = builder.add_extension(x509.SubjectAlternativeName(names), critical=False)
    certificate = builder.sign(authority.key, hashes.SHA256())
    return Issued(certificate.public_bytes(serialization.Encoding.PEM), _pem(key))


def check_host(host: str) -> str:
    """`host` itself, if a certificate can name it; raises FesError."""
    if not _NAME.fullmatch(host) and not _is_address(host):
        like = "a name like lab.example, in ASCII, or an address like 10.0.0.7, without scheme and port"
        raise FesError(f"--host expects {like}, got {host!r}")
    return host


def hosts_of(pem: bytes) -> tuple[str, ...]:
    """The host names and addresses in a certificate, none for a client's; raises ValueError."""
    certificate = x509.load_pem_x509_certificate(pem)
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return ()
    return tuple(str(name.value) for name in names)


def describe(name: str, pem: bytes) -> tuple[str, str, str, str, str]:
    """Role, serial number, end of validity, fingerprint and hosts of a certificate, as text; raises ValueError."""
    certificate = x509.load_pem_x509_certificate(pem)
    ends = certificate.not_valid_after_utc
    expired = " (expired)" if datetime.now(UTC) > ends else ""
    [common] = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    role = name if name in (common.value, AUTHORITY) else f"{name} ({common.value!r})"
    fingerprint = certificate.fingerprint(hashes.SHA256()).hex()
    until = f"{ends:%Y-%m-%d %H:%M}{expired}"
    return role, f"{certificate.serial_number:040x}", until, fingerprint, ", ".join(hosts_of(pem))


def _dated(days: float) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    return (
        x509.CertificateBuilder()
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - SKEW + min(timedelta(days=days), timedelta(0)))
        .not_valid_after(now + timedelta(days=days))
    )


def _name(common: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common)])


def _host(host: str) -> x509.GeneralName:
    return x509.IPAddress(ipaddress.ip_address(host)) if _is_address(host) else x509.DNSName(host)


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return "%" not in host  # a certificate cannot contain a zone


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
