"""Ground truth, the radio channel and the barrier.

__main__    entry point of fes-world
process     the shell: fes-world
server      the world on the bus: observations out, commands in, tick after tick
course      one run as the world goes through it
lockstep    the barrier: every tick waits for all commands
live        the live clock: ticks wait for nobody
deadlines   how robots keep its pace
checkpoint  what a run can be gone on from
lock        one world per run directory
snapshot    its file: a run at one tick
journal     notes of what came from outside since
resume      a run gone on with
attendance  who takes part at a tick
claim       one world a run
roster      who hosts which robot, and who is alive
access      who may say and hear what, as Zenoh's access control
audit       who was turned away
reporting   the report to observers
wording     between arrays and the messages of all robots
recorder    the log of a run: run.mcap
log_layout  names and bounds that its writer and reader share
log_reader  logs, read back
log_ticks   their ticks, from the messages of a file
container   its file: topics, schemas, chunks
records     the same file, read with bounds and checksums
hashed_file  files that a run writes, hashed and checked at the end
schemas     its message types
views       what viewers show of it
protobuf    how its messages are encoded
descriptors  how its message types are described
beacon_tap  the world's own copy of every beacon, by which it judges senders
command_gate  the one process that may command a robot
farewell    the end of a run, repeated until it is heard
scenario    the typed scenario, from TOML
robots_config  its table [robots]: the starts of the robots
overrides   fields of a scenario that --set overrides
toml        TOML from outside: bounded, or rejected in one line
radio_config  its table [channel]: the formula, shadowing, bursts, jammers
kinematics  the unicycle (5) on its exact arc
proximity   which pairs of robots are within communication range
crowd       memory for robots that start within range of each other
channel     which beacons decode
shadowing   correlated in space, reciprocal
bursts      losses in a row
chance      the radio's uniform numbers
simulation  step(state, twists) -> state
optimum     r*, the separation that maximizes the index (16)
graphs      connectivity of a graph, lambda_2
metrics     what a run achieved
digest      SHA-256 over all ticks
account     what a run achieved, added up from truth and telemetry
tracking    how fast and how well the optimum is found, after the start and after each change
breathing   separations averaged over a period of the dither
rules       a broken rule, in one line
expect      what a scenario expects of its run
remarks     parts of a scenario that do not run as written
events      what changes while a run goes on
equipment   faulty transmitters, and clocks that are off
summary     summary.json and scenario.toml of a run directory
"""
