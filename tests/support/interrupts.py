"""Interrupts at many moments of a short wait: `python -m tests.support.interrupts 3000`.

Each call must raise the interrupt, and end. The pauses of `background.call` are made so short that many interrupts
come between two of its instructions.
"""

import argparse
import random
import signal

from console.api import background
from console.api.background import Work, call


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("calls", type=int)
    background.PERIOD = 1e-5
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    moments = random.Random(7)
    for _ in range(parser.parse_args().calls):
        work = Work()

        def wait_for_the_stop(work: Work = work) -> None:
            # Set here, so that no interrupt comes before the call has begun.
            signal.setitimer(signal.ITIMER_REAL, moments.uniform(1e-4, 1e-3))
            while True:
                work.pause(10.0)

        try:
            call(work, wait_for_the_stop, None)
        except KeyboardInterrupt as interrupt:
            if interrupt.__notes__ != [background.INTERRUPTED]:
                raise
    print("all ended")


if __name__ == "__main__":
    main()
