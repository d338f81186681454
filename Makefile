# The commands of a developer; `python -m tests` and `python -m bench` work without make.
.PHONY: check format bench
PYTHON ?= python

check:
	$(PYTHON) -m tests

format:
	$(PYTHON) -m ruff format .
	$(PYTHON) -m ruff check --fix .

bench:
	$(PYTHON) -m bench
