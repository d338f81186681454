"""The scenario of a run.

scenario      the typed scenario, from TOML
builtin       built-in scenarios, by name
radio         its table [channel]: the formula, shadowing, bursts, jammers
starts        its table [robots]: where the robots start
faults        its table [faults]: faulty transmitters and drifting clocks
events        its events: changes while the run goes on
expectations  its expectations of the summary
validation    a broken rule, in one line
overrides     fields that --set overrides
remarks       parts of a scenario that do not run as written
toml          TOML from outside: bounded, or rejected in one line
"""
