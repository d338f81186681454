"""Every error of the project, on one page.

FesError                 an error that a person can act on: one line, exit code 1
├── ScenarioError        a scenario or an override that breaks a rule
├── MessageError         a payload that is not what its key promises
├── TransportError       the bus could not be opened, or broke
├── Unavailable          a process that is needed did not appear or answer, or left
├── Rejected             the world rejected this process, or its request
│   └── Overloaded       only for now: too many requests wait
└── Stopped              a signal ended the program before its end
"""

import errno


class FesError(Exception):
    """An error whose message is one line: the rule, then the offending value."""

    exit_code = 1


def reason(error: OSError, *, with_file: bool = True) -> str:
    """The system's text for an error, in one line; `with_file` adds its file, if it has one.

    Python's own errors, such as that of a seek in a pipe, have no text of the system, only Python's.

    >>> reason(BrokenPipeError(32, "Broken pipe"))
    'Broken pipe'
    >>> reason(FileNotFoundError(2, "No such file or directory", "a.toml"), with_file=False)
    'No such file or directory'
    >>> reason(OSError(24, "Too many open files")), reason(OSError("not seekable")), reason(TimeoutError())
    ('Too many open files (ulimit -n allows more)', 'not seekable', 'TimeoutError')
    """
    what = error.strerror or str(error) or type(error).__name__
    if error.errno == errno.EMFILE:
        what += " (ulimit -n allows more)"
    return f"{what}: {error.filename}" if with_file and error.filename is not None else what


def no_memory(error: MemoryError) -> str:
    """The allocation that failed, in one line.

    >>> no_memory(MemoryError("Unable to allocate 5 GiB"))
    'not enough memory: Unable to allocate 5 GiB'
    >>> no_memory(MemoryError())
    'not enough memory'
    """
    return ": ".join(filter(None, ("not enough memory", str(error))))


class ScenarioError(FesError):
    """A scenario or an override that breaks a rule."""

    def __init__(self, where: str, rule: str) -> None:
        self.where = where
        self.rule = rule
        super().__init__(f"{where}: {rule}")


class MessageError(FesError):
    """A payload that is not what its key promises."""

    def __init__(self, schema: str, rule: str, value: str = "") -> None:
        self.schema = schema
        self.rule = rule
        super().__init__(f"{schema}: {rule}" + (f": {value}" if value else ""))


class TransportError(FesError):
    """The bus could not be opened, or broke."""


class Unavailable(FesError):
    """A process that is needed did not appear or answer, or left."""


class Rejected(FesError):
    """The world rejected this process, or its request."""


class Overloaded(Rejected):
    """Too many requests wait: the same request may succeed later."""


class Stopped(FesError):
    """A signal ended the program before its end."""
