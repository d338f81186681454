"""fes keys and fes run --secure: permissions of the files that stay, and removal of the others."""

import argparse
import json
import os
import re
import stat
import subprocess
import sys
from pathlib import Path

from console.backends import inprocess
from console.backends.process_group import free_port
from console.keys import certificates
from fes import command_line
from fes.transport.identity import Identity
from tests.support import team_keys
from tests.support.commands import call, complaint
from tests.support.loop import load
from tests.support.paths import CONFIGS, PAIR
from tests.support.processes import PATIENCE, children, command, start, until


def modes(directory: Path) -> dict[str, int]:
    """The permissions of a directory, as `.`, and of all files in it."""
    return {path.name or ".": stat.S_IMODE(path.stat().st_mode) for path in (directory, *directory.iterdir())}


def test_keys_are_readable_by_their_owner_only_and_valid(tmp_path: Path) -> None:
    done = call(tmp_path, "fes", "keys", "init", "--robots", "2", "--host", "lab.example", "--days", "30")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "keys: an authority and 5 certificates, valid for 30 days\n"
    keys = tmp_path / "keys"
    result = modes(keys)
    assert result.pop("keys") == 0o700
    roles = ["world", "observer", "operator", "robot-0", "robot-1"]
    assert set(result) == {f"{name}.{kind}" for name in ["ca", *roles] for kind in ("crt", "key")}
    assert set(result.values()) == {0o600}
    for role in roles:
        Identity(keys, role).check()


def test_a_second_authority_is_rejected_and_issue_adds_and_replaces(tmp_path: Path) -> None:
    assert call(tmp_path, "fes", "keys", "init").returncode == 0
    line = complaint(call(tmp_path, "fes", "keys", "init"), "fes")
    assert line == "--keys keys: the folder has an authority already; fes keys issue adds certificates to it"
    before = (tmp_path / "keys/world.crt").read_bytes()
    done = call(tmp_path, "fes", "keys", "issue", "robot-0-4", "world", "--host", "10.0.0.7")
    served = "names of the world: localhost, 127.0.0.1, 10.0.0.7\n"
    assert (done.returncode, done.stdout) == (0, f"keys: robot-0-4, world, valid for 365 days\n{served}")
    assert (tmp_path / "keys/world.crt").read_bytes() != before
    Identity(tmp_path / "keys", "robot-0-4").check()
    line = complaint(call(tmp_path, "fes", "keys", "issue", "observer", "--host", "10.0.0.7"), "fes")
    assert line == "--host is only for the certificate of the world, not for that of observer"


def test_the_list_shows_role_serial_expiry_and_fingerprint_but_no_key(tmp_path: Path) -> None:
    call(tmp_path, "fes", "keys", "init", "--robots", "11")
    done = call(tmp_path, "fes", "keys", "list")
    header, *rows = done.stdout.splitlines()
    assert header.split()[:2] == ["role", "serial"]
    names = [row.split()[0] for row in rows]
    robots = [name for name in names if name.startswith("robot")]
    assert robots == [f"robot-{robot}" for robot in range(11)]  # 10 after 9
    assert set(names) - set(robots) == {"ca", "world", "observer", "operator"}
    line = re.compile(r"\S+ +[0-9a-f]{40} +\d{4}-\d\d-\d\d \d\d:\d\d +[0-9a-f]{64} *(localhost.*)?")
    assert all(line.fullmatch(row) for row in rows)
    hosts = {row.split()[0]: row.rpartition("  ")[2] for row in rows if "localhost" in row}
    assert hosts == {"world": "localhost, 127.0.0.1"}
    assert "PRIVATE" not in done.stdout


def test_an_invalid_host_is_rejected_before_anything_is_written(tmp_path: Path) -> None:
    umlaut = os.fsdecode("ü.example".encode())  # the only way to pass it in an ASCII locale
    for host in (umlaut, "lab.example:7447"):
        line = complaint(call(tmp_path, "fes", "keys", "init", "--host", "lab.example", "--host", host), "fes")
        assert line.endswith(f"without scheme and port, got {host!r}")
        assert not (tmp_path / "keys").exists()
    assert call(tmp_path, "fes", "keys", "init").returncode == 0
    before = (tmp_path / "keys/world.crt").read_bytes()
    complaint(call(tmp_path, "fes", "keys", "issue", "world", "--host", umlaut), "fes")
    assert (tmp_path / "keys/world.crt").read_bytes() == before


def test_a_renewed_certificate_of_the_world_keeps_its_names_unless_others_are_given(tmp_path: Path) -> None:
    call(tmp_path, "fes", "keys", "init", "--host", "lab.example", "--host", "fd00::7")
    world = tmp_path / "keys/world.crt"
    before = world.read_bytes()
    done = call(tmp_path, "fes", "keys", "issue", "world", "observer")
    assert done.stdout.splitlines()[1] == "names of the world: localhost, 127.0.0.1, lab.example, fd00::7"
    assert world.read_bytes() != before
    assert certificates.hosts_of(world.read_bytes()) == ("localhost", "127.0.0.1", "lab.example", "fd00::7")
    assert certificates.hosts_of((tmp_path / "keys/observer.crt").read_bytes()) == ()
    call(tmp_path, "fes", "keys", "issue", "world", "--host", "new.example")
    assert certificates.hosts_of(world.read_bytes()) == ("localhost", "127.0.0.1", "new.example")
    world.write_text("none")
    line = complaint(call(tmp_path, "fes", "keys", "issue", "world"), "fes")
    assert line == "keys/world.crt: not a certificate, so its names are unknown: name them with --host"


def test_keys_are_not_written_where_others_can_write(tmp_path: Path) -> None:
    call(tmp_path, "fes", "keys", "init")
    keys = tmp_path / "keys"
    before = {path: path.read_bytes() for path in keys.iterdir()}
    for mode in (0o777, 0o1777, 0o770):
        keys.chmod(mode)
        line = complaint(call(tmp_path, "fes", "keys", "issue", "robot-0"), "fes")
        assert line == f"--keys keys: other users can write to it (mode {mode:04o}): chmod 700 keys"
    assert {path: path.read_bytes() for path in keys.iterdir()} == before
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    complaint(call(tmp_path, "fes", "keys", "init", "--keys", "open"), "fes")
    assert not list((tmp_path / "open").iterdir())


def test_an_authority_with_a_foreign_key_issues_no_certificate(tmp_path: Path) -> None:
    for directory in ("keys", "other"):
        call(tmp_path, "fes", "keys", "init", "--keys", directory)
    (tmp_path / "other/ca.key").replace(tmp_path / "keys/ca.key")
    line = complaint(call(tmp_path, "fes", "keys", "issue", "robot-0"), "fes")
    assert line == "keys/ca.key: is not the key of ca.crt"
    assert not (tmp_path / "keys/robot-0.crt").exists()


def test_no_rules_are_printed_for_missing_certificates(tmp_path: Path) -> None:
    line = complaint(call(tmp_path, "fes", "keys", "rules", "--robots", "2"), "fes")
    assert line == "--keys keys: the world needs ca.crt, and there is none"


def test_a_missing_extra_is_named_in_one_line(tmp_path: Path) -> None:
    call(tmp_path, "fes", "keys", "init", "--robots", "1")
    for module, words in (
        ("console.cli", ["keys", "issue", "world"]),
        ("agents.process", ["--id", "0", "--keys", "keys"]),
        ("world.process", [PAIR, "--keys", "keys"]),
    ):
        code = f"import sys; sys.modules['cryptography'] = None; from {module} import main; main()"
        done = subprocess.run([sys.executable, "-c", code, *words], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 1
        remedy = "pip install -e '.[security]'  # in a clone of fes"
        assert done.stderr.endswith(f"error: certificates need cryptography: {remedy}\n")


def test_a_secure_run_has_the_same_digest_and_leaves_no_keys(tmp_path: Path) -> None:
    words = ["fes", "run", str(CONFIGS / "paper.toml"), "--duration", "2", "--headless", "--json", "--secure"]
    done = call(tmp_path, *words, "--agents-per-process", "4")
    assert (done.returncode, done.stderr) == (0, "starting a world and 10 robots in 3 processes ...\n")
    expected = inprocess.run(load("paper.toml", run__duration=2.0), "paper")["digest"]
    assert json.loads(done.stdout)["digest"] == expected
    left = {path.name for path in (tmp_path / "runs/latest").iterdir()}
    logs = {"world.log", "agent-0-3.log", "agent-4-7.log", "agent-8-9.log"}
    assert left == {"scenario.toml", "summary.json", "run.mcap"} | logs
    said = "".join(path.read_text() for path in (tmp_path / "runs/latest").glob("*.log"))
    assert "PRIVATE" not in said
    assert "dropped" not in logs


def test_view_and_set_find_the_certificates_of_the_latest_run(tmp_path: Path) -> None:
    words = ["run", PAIR, "--duration", "16", "--rtf", "1", "--headless", "--json", "--secure"]
    running = start(command("console.cli", *words), tmp_path)
    log = tmp_path / "runs/latest/world.log"
    until(lambda: log.exists() and "all robots are here" in log.read_text())
    assert set(modes(tmp_path / "runs/latest/keys").values()) == {0o600, 0o700}
    assert not (tmp_path / "runs/latest/keys/ca.key").exists()
    viewing = start(command("console.cli", "view"), tmp_path)
    changed = call(tmp_path, "fes", "set", "channel.reference_snr=5e6")
    assert (changed.returncode, changed.stdout[:36]) == (0, "channel.reference_snr = 5000000.0 fr"), changed
    _, err = viewing.communicate(timeout=PATIENCE)
    assert viewing.returncode == 0, err
    out, err = running.communicate(timeout=PATIENCE)
    assert running.returncode == 0, err
    assert json.loads(out)["ticks"] == 800
    assert not (tmp_path / "runs/latest/keys").exists()


def listening(pid: int) -> list[str]:
    """The addresses, as /proc writes them, on which a process listens: TCP, and any UDP."""
    links = [str(path.readlink()) for path in Path(f"/proc/{pid}/fd").iterdir() if path.is_symlink()]
    inodes = {link[8:-1] for link in links if link.startswith("socket:[")}
    result = []
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes and (table.startswith("udp") or fields[3] == "0A"):
                result.append(f"{table} {fields[1].partition(':')[0]}")
    return result


def test_only_the_world_listens_and_only_on_loopback(tmp_path: Path) -> None:
    running = start(command("console.cli", "run", PAIR, "--duration", "100000", "--json"), tmp_path)
    log = tmp_path / "runs/latest/world.log"
    try:
        until(lambda: log.exists() and "all robots are here" in log.read_text())
        result = {line.split("-m ")[1].split()[0]: listening(pid) for pid, line in children(running.pid).items()}
        assert result == {"world": ["tcp 0100007F"], "agents": []}
        assert listening(running.pid) == []
    finally:
        running.terminate()
        running.communicate(timeout=PATIENCE)


def test_without_flags_endpoints_are_on_loopback_with_and_without_keys(tmp_path: Path) -> None:
    team_keys.directory(tmp_path / "k", certificates.create(1.0), ["world", "robot-3"])
    parser = argparse.ArgumentParser()
    command_line.add_network_flags(parser)
    for words, endpoint in (([], "tcp/127.0.0.1:7447"), (["--keys", str(tmp_path / "k")], "tls/127.0.0.1:7447")):
        flags = parser.parse_args(words)
        assert command_line.world_endpoints(flags).listen == (endpoint,)
        agent = command_line.agent_endpoints(flags, 1.0, "robot-3")
        assert (agent.connect, agent.listen) == ((endpoint,), ())


def test_a_world_that_listens_without_tls_for_other_machines_logs_a_warning(tmp_path: Path) -> None:
    endpoint = f"tcp/0.0.0.0:{free_port()}"
    world = start(command("world.process", PAIR, "-l", endpoint), tmp_path)
    assert world.stderr is not None
    output = world.stderr.readline()
    world.terminate()
    world.communicate(timeout=PATIENCE)
    assert f"network: listening on {endpoint} without TLS" in output
    assert "--keys DIR" in output
