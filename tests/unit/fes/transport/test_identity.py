"""Identity: what is wrong with a certificate is found before a session opens, and said in one line."""

import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from console.keys import certificates
from fes.errors import FesError
from fes.transport import identity
from fes.transport.endpoints import Endpoints, exposed, warn_if_exposed
from fes.transport.identity import Identity
from tests.support import team_keys


@pytest.fixture(scope="module")
def issuer() -> certificates.Authority:
    return certificates.create(2.0)


@pytest.fixture
def keys(issuer: certificates.Authority, tmp_path: Path) -> Path:
    return team_keys.directory(tmp_path / "keys", issuer, ["world", "robot-3", "robot-0-2"])


def wrong(directory: Path, role: str) -> str:
    with pytest.raises(FesError) as caught:
        Identity(directory, role).check()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_valid_certificates_pass(keys: Path) -> None:
    for role in ("world", "robot-3", "robot-0-2"):
        Identity(keys, role).check()


def test_a_missing_file_is_named(keys: Path) -> None:
    assert wrong(keys, "robot-4") == f"--keys {keys}: the robot-4 needs robot-4.crt, and there is none"
    (keys / "robot-3.key").unlink()
    assert wrong(keys, "robot-3") == f"--keys {keys}: the robot-3 needs robot-3.key, and there is none"
    (keys / "ca.crt").unlink()
    assert wrong(keys, "world") == f"--keys {keys}: the world needs ca.crt, and there is none"


def test_an_expired_certificate_is_named_with_its_end(keys: Path, issuer: certificates.Authority) -> None:
    team_keys.write(keys, "robot-3", certificates.issue(issuer, "robot-3", days=-1.0))
    yesterday = datetime.now(UTC) - timedelta(days=1)
    line = wrong(keys, "robot-3")
    assert line.startswith(f"{keys}/robot-3.crt: the certificate expired on {yesterday:%Y-%m-%d}")


def test_certificates_of_another_authority_of_none_and_of_another_key_are_distinguished(keys: Path) -> None:
    other = certificates.create(2.0)
    team_keys.write(keys, "robot-3", certificates.issue(other, "robot-3", 1.0))
    assert wrong(keys, "robot-3") == f"{keys}/robot-3.crt: was not issued by ca.crt beside it"
    team_keys.write(keys, "robot-3", other.pem)  # signed by itself
    assert wrong(keys, "robot-3") == f"{keys}/robot-3.crt: was not issued by ca.crt beside it"
    shutil.copy(keys / "robot-0-2.key", keys / "world.key")
    assert wrong(keys, "world") == f"{keys}/world.key: is not the key of world.crt"
    (keys / "world.crt").write_text("no certificate")
    assert wrong(keys, "world").startswith(f"{keys}: the certificate or key of the world is invalid")


def test_a_certificate_of_another_name_is_named(keys: Path) -> None:
    for suffix in ("crt", "key"):
        shutil.copy(keys / f"robot-3.{suffix}", keys / f"robot-1.{suffix}")
    assert wrong(keys, "robot-1") == f"{keys}/robot-1.crt: is that of 'robot-3', not of 'robot-1'"


def test_a_key_that_others_can_read_or_change_causes_a_warning(keys: Path, caplog: pytest.LogCaptureFixture) -> None:
    for mode, warned in ((0o600, False), (0o400, False), (0o440, False), (0o644, True), (0o660, True), (0o602, True)):
        caplog.clear()
        (keys / "world.key").chmod(mode)
        identity.security(keys, "world")
        line = f"{keys}/world.key: others on this machine can read or change it (mode {mode:04o}): "
        assert [record.getMessage() for record in caplog.records] == [line + f"chmod 600 {keys}/world.key"] * warned


def test_only_the_world_can_serve_and_under_the_names_it_was_given(issuer: certificates.Authority) -> None:
    world = x509.load_pem_x509_certificate(
        certificates.issue(issuer, "world", 1.0, ("10.0.0.7", "lab.example")).certificate
    )
    names = world.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert names.get_values_for_type(x509.DNSName) == ["localhost", "lab.example"]
    assert [str(ip) for ip in names.get_values_for_type(x509.IPAddress)] == ["127.0.0.1", "10.0.0.7"]
    robot = x509.load_pem_x509_certificate(certificates.issue(issuer, "robot-3", 1.0).certificate)
    purposes = [
        list(certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value)
        for certificate in (world, robot)
    ]
    assert ExtendedKeyUsageOID.SERVER_AUTH in purposes[0]
    assert purposes[1] == [ExtendedKeyUsageOID.CLIENT_AUTH]
    assert [name.value for name in robot.subject.get_attributes_for_oid(NameOID.COMMON_NAME)] == ["robot-3"]


def test_a_restored_authority_issues_what_the_first_one_vouches_for(issuer: certificates.Authority) -> None:
    again = certificates.restore(issuer.pem)
    robot = x509.load_pem_x509_certificate(certificates.issue(again, "robot-3", 1.0).certificate)
    robot.verify_directly_issued_by(issuer.certificate)
    assert (
        robot.fingerprint(hashes.SHA256()).hex()
        == certificates.describe("robot-3", robot.public_bytes(serialization.Encoding.PEM))[3]
    )


@pytest.mark.parametrize(
    "host", ["lab.example", "Lab-2.example", "my_world", "xn--4ca.example", "10.0.0.7", "fd00::7", "2.example"]
)
def test_a_host_is_a_name_or_an_address(host: str, issuer: certificates.Authority) -> None:
    assert certificates.check_host(host) == host
    assert certificates.hosts_of(certificates.issue(issuer, "world", 1.0, (host,)).certificate)[2:] == (host,)


@pytest.mark.parametrize(
    "host",
    ["", "bad host!", "lab.example:7447", "tls/lab", "ü.example", "10.0.0", "10.0.0.256", "[::1]", "-lab", "lab.",
     "a..b", "*.example", "fe80::1%eth0", "lab\n", "a" * 64, "a." * 127 + "a"],
)  # fmt: skip
def test_other_names_are_not_hosts(host: str) -> None:
    with pytest.raises(FesError) as caught:
        certificates.check_host(host)
    assert str(caught.value).startswith("--host expects a name like lab.example")
    assert str(caught.value).endswith(f"got {host!r}")


@pytest.mark.parametrize("role", ["world", "observer", "operator", "robot-0", "robot-12", "robot-0-9"])
def test_valid_roles_pass(role: str) -> None:
    assert identity.check_role(role) == role


@pytest.mark.parametrize(
    "role", ["", "ca", "robot", "robot-", "robot-03", "robot-5-2", "robot-1-1", "robot-*", "world "]
)
def test_other_names_are_not_roles(role: str) -> None:
    with pytest.raises(FesError, match="a role is world, observer, operator"):
        identity.check_role(role)


@pytest.mark.parametrize("role", ["robot-100000", "robot-0-100000", "robot-0-9999999999"])
def test_a_role_of_robots_that_no_run_can_have_is_not_a_role(role: str) -> None:
    assert identity.check_role("robot-99998-99999")
    with pytest.raises(FesError, match=f"^a run has robots 0 to 99999 at most, got '{role}'$"):
        identity.check_role(role)


def test_crews_are_found_by_their_certificates(keys: Path) -> None:
    assert identity.crews(keys) == [range(3)]


def test_with_certificates_an_endpoint_must_be_tls(keys: Path) -> None:
    own = Identity(keys, "world").settings()
    with pytest.raises(FesError, match=r"^--keys needs an endpoint like tls/127.0.0.1:7447: tcp/127.0.0.1:1$"):
        Endpoints("router", (), ("tcp/127.0.0.1:1",), security=own)


@pytest.mark.parametrize(
    ("endpoint", "expected"),
    [
        ("tcp/127.0.0.1:7447", False),
        ("tcp/localhost:7447", False),
        ("tcp/[::1]:7447", False),
        ("unixsock-stream//tmp/x", False),
        ("tls/0.0.0.0:7447", False),
        ("quic/10.0.0.1:7447", False),
        ("tcp/0.0.0.0:7447", True),
        ("tcp/[::]:7447", True),
        ("udp/192.168.0.2:7447?rel=0", True),
        ("tcp/lab.example:7447", True),
        ("tcp/[fe80::1%eth0]:7447", True),
    ],
)
def test_an_endpoint_is_exposed_if_another_machine_reaches_it_without_tls(endpoint: str, expected: bool) -> None:
    assert exposed(endpoint) == expected


def test_a_warning_names_each_exposed_endpoint_and_the_flag(caplog: pytest.LogCaptureFixture) -> None:
    warn_if_exposed('{"router": ["tcp/0.0.0.0:1", "tcp/127.0.0.1:2"], "peer": ["udp/10.0.0.1:3"]}')
    assert [record.args for record in caplog.records] == [("tcp/0.0.0.0:1",), ("udp/10.0.0.1:3",)]
    assert all("--keys DIR" in record.message for record in caplog.records)
