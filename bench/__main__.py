"""All benchmarks, in sequence: `python -m bench`."""

from bench.size import cost, growth
from bench.speed import compute, lockstep, recording, secure, startup

if __name__ == "__main__":
    compute.main()
    startup.main()
    lockstep.main()
    recording.main()
    secure.main()
    growth.main()
    cost.main()
