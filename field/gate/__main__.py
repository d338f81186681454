"""`python -m field.gate --link FD`: the gate of one robot, started by its agent.

The first line of standard input has the settings in JSON. FD is the gate's end of the link. The agent's end ends the
gate. Signals of a terminal do not: the agent has to stop first.
"""

import argparse
import signal
import socket
import sys

from fes import process
from fes.system import background_log, output
from field.gate import process as gate_process
from field.gate.link import TO_GATE, FrameSocket
from field.gate.rules import settings

DRAIN = 0.5
"""Longest wait for the log at the end, when the robot stands [s]."""

LONGEST_LINE = 1 << 20
"""Longest line of settings [bytes]."""


def main() -> None:
    """Entry point of the gate's process."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    output.configure()
    parser = argparse.ArgumentParser(prog="field.gate", description="The gate of one robot; its agent starts it.")
    parser.add_argument("--link", type=int, required=True, metavar="FD", help="descriptor of the link to the agent")
    flags = parser.parse_args()
    line = sys.stdin.buffer.readline(LONGEST_LINE)

    async def serve() -> int:
        drain = background_log.detach()
        try:
            agent = FrameSocket(socket.socket(fileno=flags.link), TO_GATE)
            return await gate_process.serve(settings.from_json(line), agent)
        finally:
            drain(DRAIN)

    process.run("fes-gate", serve)


if __name__ == "__main__":
    main()
