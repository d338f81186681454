"""All benchmarks, one after the other: `python -m bench`."""

from bench import compute, cost, growth, lockstep, recording, secure, startup

if __name__ == "__main__":
    compute.main()
    startup.main()
    lockstep.main()
    recording.main()
    secure.main()
    growth.main()
    cost.main()
