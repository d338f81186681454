"""The audit on lines of Zenoh 1.10's log: it separates real attempts from those that Zenoh only computes ahead."""

import logging

import pytest

from fes.transport.drop_log import LONGEST_LINE
from world.server.audit import KINDS_PER_NAME, Audit

PLACE = "zenoh::net::routing::interceptor::access_control:"
TRACE = f"2026-11-22T04:02:14.951301Z TRACE app-1 ThreadId(03) {PLACE}"
WHO = "5630af on Interface(lo)+CertCommonName(robot-3)+Transport(Tls)+5630af"
KEY = "fes/main/robot/4/beacon"
ACTIONS = [
    "Query",
    "Reply",
    "Put",
    "Delete",
    "Declare/Undeclare Subscriber",
    "Declare/Undeclare Queryable",
    "Declare/Undeclare Liveliness Token",
    "Liveliness Query",
    "Declare Liveliness Subscriber",
]


def ahead(flow: str) -> list[str]:
    """The lines that Zenoh logs when it computes the permissions of a key."""
    denials = [f"{TRACE} {WHO} is unauthorized to {action} ({flow}) on {KEY}" for action in ACTIONS]
    return [f"{TRACE} ACL ({flow}): caching permissions for `{KEY}` ...", *denials]


def cached(action: str, key: str = KEY) -> str:
    return f"{TRACE} Using cached result: 5630af is unauthorized to {action} on {key}"


def counted(*lines: str) -> dict[str, int]:
    return dict(fed(*lines).counts)


def fed(*lines: str) -> Audit:
    audit = Audit(logging.getLogger("test"), ["robot-3", "operator"])
    audit.feed("".join(f"{line}\n" for line in lines).encode())
    return audit


def test_a_permission_that_is_computed_in_advance_is_not_an_attempt() -> None:
    assert counted(*ahead("ingress"), *ahead("egress")) == {}


def test_an_attempt_is_counted_with_the_name_on_its_certificate() -> None:
    attempts = [cached("Put (ingress)")] * 3 + [cached("Liveliness Token (ingress)", "fes/main/robot/4/alive")]
    assert counted(*ahead("ingress"), *attempts) == {
        f"robot-3: put on {KEY}": 3,
        "robot-3: liveliness token on fes/main/robot/4/alive": 1,
    }


def test_an_attempt_without_a_cached_result_is_distinguished_from_the_same_line_computed_in_advance() -> None:
    plain = f"{TRACE} {WHO} is unauthorized to Query (ingress) on {KEY}"
    assert counted(*ahead("ingress"), *ahead("egress"), plain) == {f"robot-3: query on {KEY}": 1}
    assert counted(plain) == {f"robot-3: query on {KEY}": 1}


def test_an_undelivered_message_and_a_permitted_one_are_not_attempts() -> None:
    permitted = f"{TRACE} Using cached result: 5630af is authorized to Put (ingress) on fes/main/robot/3/beacon"
    assert counted(cached("Put (egress)"), permitted) == {}


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("invalid peer certificate: certificate expired: verification time 9 (UNIX)", "its certificate has expired"),
        ("invalid peer certificate: UnknownIssuer", "its certificate is not of this run's authority"),
        ("peer sent no certificates", "it has no certificate"),
        ("received corrupt message of type InvalidContentType", "it does not speak TLS"),
        ("received fatal alert: DecryptError", "it does not trust the world's certificate"),
    ],
)
def test_a_failed_connection_is_explained_in_plain_words(said: str, meant: str) -> None:
    line = f"2026-11-22T04:01:46Z  WARN app-3 ThreadId(11) zenoh_link_tls::unicast: {said}. Hint: increase the limit."
    assert counted(line, line) == {f"connection: {meant}": 2}


def test_each_kind_is_logged_once_however_the_log_is_split(caplog: pytest.LogCaptureFixture) -> None:
    audit = Audit(logging.getLogger("test"), ["robot-3"])
    log = "".join(f"{line}\n" for line in [*ahead("ingress"), *[cached("Put (ingress)")] * 5]).encode()
    for start in range(0, len(log), 37):
        audit.feed(log[start : start + 37])
    assert audit.counts == {f"robot-3: put on {KEY}": 5}
    [record] = caplog.records
    assert f"robot-3's put on {KEY}: it has no right to it" in record.message


def denied(name: str, key: str) -> str:
    """The line of a denied put by a client with this name on its certificate."""
    return f"{TRACE} {WHO.replace('robot-3', name)} is unauthorized to Put (ingress) on {key}"


def test_a_client_that_fills_the_log_with_made_up_keys_and_names_hides_no_other(
    caplog: pytest.LogCaptureFixture,
) -> None:
    made_up = [denied("robot-3", f"made/up/{number}") for number in range(10 * KINDS_PER_NAME)]
    strangers = [denied(f"nobody-{number}", KEY) for number in range(10 * KINDS_PER_NAME)]
    no_tls = f"{TRACE} zenoh_link_tls::unicast: received corrupt message"
    audit = fed(*made_up, *strangers, denied("operator", KEY), denied("operator", KEY), no_tls)
    logged = [record.getMessage() for record in caplog.records]
    lines = [sum(name in line for line in logged) for name in ("robot-3's", "nobody", "operator's")]
    assert lines == [KINDS_PER_NAME + 1, KINDS_PER_NAME + 1, 1]
    last = f"dropped robot-3's put on made/up/{KINDS_PER_NAME}: it has no right to it"
    assert f"{last} (further kinds are counted, not shown)" in logged
    assert "dropped a connection: it does not speak TLS" in logged[-1]
    caplog.clear()
    audit.log_total()
    totals = [record.getMessage() for record in caplog.records]
    assert totals[0] == "dropped messages: connection: it does not speak TLS x1"
    assert f"dropped messages: operator: put on {KEY} x2" in totals
    assert sum(f"robot-3: other x{9 * KINDS_PER_NAME}, robot-3: put on" in line for line in totals) == 1
    assert len(totals) == 4


def test_a_key_can_forge_neither_a_line_about_the_totals_nor_a_long_line(caplog: pytest.LogCaptureFixture) -> None:
    audit = fed(*[denied("operator", f"a/\rFORGED {letter * 20_000}") for letter in "abcdefghij"])
    audit.log_total()
    assert len(caplog.records) == 11
    for record in caplog.records:
        assert record.getMessage().isprintable()
        assert "\\rFORGED" in record.getMessage()
        assert len(record.getMessage()) < 9 * (LONGEST_LINE + 10)
