"""An agent for tests, as a process: it starts a gate, prints its pid, and commands a velocity at 50 Hz.

`python -m tests.support.gate_agent LINEAR`: the first line of standard input has the gate's settings. After a freeze
this agent sends the commands of all periods that it has missed, each with the time of its own period.
"""

import asyncio
import sys
import time

from field.gate.launch import launch
from field.gate.link import Command
from field.gate.rules import settings

PERIOD = 20_000_000
"""Period of the commands [ns]."""


async def drive(line: str, linear: float) -> None:
    """Command a velocity until this process or the gate ends."""
    async with await launch(settings.from_json(line)) as link:
        print(link.pid, flush=True)
        deadline, sequence = time.monotonic_ns(), 0
        while not link.is_closed:
            deadline += PERIOD
            await asyncio.sleep((deadline - time.monotonic_ns()) / 1e9)
            while deadline <= time.monotonic_ns():
                sequence += 1
                link.send(Command(sequence, deadline, linear, 0.0, deadline))
                deadline += PERIOD
            deadline -= PERIOD
    print("ended", flush=True)


if __name__ == "__main__":
    asyncio.run(drive(sys.stdin.readline(), float(sys.argv[1])))
