"""What a person runs: fes run, fes view."""
