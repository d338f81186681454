"""Runs that a process has announced in the present folder."""

from console.connect import run_directory
from console.connect.run_directory import Address
from fes.protocol import keys
from tests.support.commands import vacant


def announce(name: str, pid: int) -> Address:
    """Announce a run of the current folder, by the process `pid`."""
    directory = run_directory.ROOT / name
    directory.mkdir(parents=True)
    address = Address(vacant(), keys.DEFAULT_RUN, pid)
    run_directory.announce(directory, address)
    return address
