"""One digest under every processor and library: `tests/portability/run` runs one program in all settings it can have.

__main__      all settings of one call, and the verdict;
comparison    one setting, compared with the first one;
settings      switches that take parts of the processor away;
interpreters  this Python, others, and an emulated one;
downloads     wheels and Debian packages in folders;
wheels        wheels of this clone with the compiled core;
verdict       outputs of two settings, compared;
digests       the program: a line of hashes for each case;
cases         the scenarios, and variants of them;
controls      what a setting changed, in results that no run uses;
logs          logs, recorded in one setting and executed in another.

The first seven import only Python's own library.
"""
