"""Libraries as wheels, and Pythons as Debian packages, unpacked into folders and not installed.

Both come from where the machine's own pip and apt are configured to look.
"""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).absolute().parents[2]
SOURCES = Path("/etc/apt/sources.list.d/debian.sources")
TAGS = ("manylinux2014", "manylinux_2_17", "manylinux_2_27", "manylinux_2_28")
MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
"""Debian's name of a machine -> the name in wheels and paths."""

UNUSED = ("debconf", "dpkg", "tar", "perl", "libdb5", "libtirpc", "readline")
"""Begin the names of packages that only an installation needs."""


class Unavailable(Exception):
    """Something cannot be downloaded or unpacked here; the text gives the reason."""


def run(*words: str | Path, **environment: str) -> str:
    """Output of a command; raises Unavailable with its last line of errors."""
    done = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, check=False, env=os.environ | environment
    )
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or done.stdout.strip().splitlines() or ["no output"]
        raise Unavailable(f"{Path(str(words[0])).name} {words[1]}: {lines[-1]}")
    return done.stdout


def libraries(folder: Path, pip: Path, minor: str, machine: str, oldest: bool = False) -> Path:
    """Folder of the project's dependencies for Python `minor`, with the oldest numpy that it allows or the newest."""
    if (folder / "whole").exists():
        return folder
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    wanted = [
        name.replace(">=", "==") if oldest and name.startswith("numpy") else name for name in project["dependencies"]
    ]
    platforms = [word for tag in TAGS for word in ("--platform", f"{tag}_{machine}")]
    run(
        pip, "install", "-q", "--no-compile", "--target", folder, *platforms,
        "--implementation", "cp", "--python-version", minor, "--only-binary=:all:", *wanted,
    )  # fmt: skip
    # The packages themselves are this clone's: only what `pip install -e` says about them is missing.
    said = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    said.mkdir(exist_ok=True)
    (said / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    (folder / "whole").touch()
    return folder


def packages(folder: Path, suite: str, machine: str, *names: str, alone: bool = False) -> Path:
    """Folder with Debian packages of `suite` for `machine`, and unless `alone` with all that they need."""
    if (folder / "whole").exists():
        return folder
    if not SOURCES.is_file():
        raise Unavailable(f"the packages' sources are not in {SOURCES}")
    apt = folder.with_name(f"{folder.name}-apt")
    for part in ("state/lists/partial", "cache/archives/partial", "sources"):
        (apt / part).mkdir(parents=True, exist_ok=True)
    (apt / "status").touch()
    lines = SOURCES.read_text().split("\n\n")[0].splitlines()
    lines = [f"Suites: {suite}" if line.startswith("Suites:") else line for line in lines]
    (apt / "sources" / "all.sources").write_text("\n".join(lines) + "\n")
    (apt / "conf").write_text(
        f'APT::Architecture "{machine}"; APT::Architectures {{ "{machine}"; }}; Dir::State "{apt}/state";\n'
        f'Dir::State::status "{apt}/status"; Dir::Cache "{apt}/cache"; Dir::Etc::sourcelist "/dev/null";\n'
        f'Dir::Etc::sourceparts "{apt}/sources"; APT::Sandbox::User "root"; APT::Keep-Downloaded-Packages "true";\n'
        'APT::Install-Recommends "false";\n'
    )
    settings = {"APT_CONFIG": str(apt / "conf"), "DEBIAN_FRONTEND": "noninteractive"}
    run("apt-get", "update", "-qq", **settings)
    archives = apt / "cache" / "archives"
    if alone:
        run("sh", "-c", 'cd "$0" && apt-get download -qq "$@"', archives, *names, **settings)
    else:
        run("apt-get", "install", "-y", "-qq", "--download-only", *names, **settings)
    for package in sorted(archives.glob("*.deb")):
        if not package.name.startswith(UNUSED):
            run("dpkg-deb", "-x", package, folder)
            package.unlink()
    if not (folder / "lib").exists():  # the package that would make this link is not unpacked
        (folder / "lib").symlink_to("usr/lib")
    (folder / "whole").touch()
    return folder


def pip_of(folder: Path) -> Path:
    """The pip of an environment of its own; raises Unavailable."""
    pip = folder / "bin" / "pip"
    if not pip.exists():
        run(sys.executable, "-m", "venv", folder)
    return pip
