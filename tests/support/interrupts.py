"""Interrupts at many moments of a short wait: `python -m tests.support.interrupts 3000`.

Each call must raise the interrupt, and end. The pauses of `background.call` are made so short that many interrupts
come between two of its instructions.
"""

import argparse
import random
import signal
import threading

from console.api import background
from console.api.background import Work, call


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("calls", type=int)
    background.PERIOD = 1e-5
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    moments = random.Random(7)
    for _ in range(parser.parse_args().calls):
        work, started = Work(), threading.Event()

        def wait_for_the_stop(work: Work = work, started: threading.Event = started) -> None:
            # No interrupt comes while the thread starts: Python's own wait there can turn it into a RuntimeError.
            started.wait()
            signal.setitimer(signal.ITIMER_REAL, moments.uniform(1e-4, 1e-3))
            while True:
                work.pause(10.0)

        try:
            call(work, wait_for_the_stop, lambda _, __, started=started: started.set())  # type: ignore[misc]
        except KeyboardInterrupt as interrupt:
            if interrupt.__notes__ != [background.INTERRUPTED]:
                raise
    print("all ended")


if __name__ == "__main__":
    main()
