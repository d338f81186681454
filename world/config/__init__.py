"""The scenario of a run.

scenario      the typed scenario, from TOML
builtin       built-in scenarios, by name
timing        its table [run]: duration, tick, seed and clock
radio         its table [channel]: the formula, shadowing, bursts, jammers
starts        its table [robots]: where the robots start
faults        tables [event.transmitter] and [event.clock] of an event: faulty transmitters and skewed clocks
events        its tables [[event]]: changes during the run
expectations  its tables [[expect]]: expectations of the summary
schema        the tables of its file, with its schemes
hardware      its table [tabletop]: a team of small robots on a table
outside       the code of its extensions, the file of its trace, and named variants
overrides     overrides of its fields by --set
remarks       parts of a scenario that do not run as written
"""
