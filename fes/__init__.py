"""What world and robots must agree on, and nothing either side should keep private.

arrays      type aliases for the arrays that every signature speaks of
edges       directed pairs (robot, peer) of a crew, and sums over them in a fixed order
geometry    wrap, separation, line of sight
fingerprint  fingerprint of the arithmetic, which processors and libraries round differently
draws       random numbers as a function of (seed, stream, tick, sender, receiver)
outage      equations (3) and (4); of the agents only agents.oracle may import it
objective   the robots' own half of the performance index (16)
config      AgentConfig: all that an agent may know
stability   rules between the tick and the gains
counts      how often one setting fits into another
contacts    the peers in range, and what was last heard of each
sensing     what a crew senses and says in one tick, as arrays
messages    Welcome, Observation, Beacon, Command, and their encoding
report      Report, what observers see, and its encoding
about       what a world says of itself to who asks
change      what a person asks the world to change, and what came of it
wire        fields of a payload, packed and checked
keys        every key expression, in one table
identity    who a process is: the certificate of its role
endpoints   how a process takes part in the network
addresses   rules of an endpoint's address, and names that do not resolve
handshake   why a session did not open
health      whether a port is listened at, or a connection stands: for health checks
bus         a session of Zenoh: everything it declares, and its way to asyncio
session     how it is opened
inbox       from Zenoh's threads to the loop, one wake-up a tick
complaints  bad messages, counted and logged once a kind
signals     stop signals during imports, and cleanups before a second signal ends a process
output      text that leaves a process: any encoding, no control characters
strict_json JSON without NaN and Infinity
files       files from others, read with a bound on their size
process     signals, exit codes, Zenoh's command-line flags
distribution  name and version of the installed distribution, and how a clone installs it
encoding    text from outside: files, arguments and names, in any encoding
memory      memory that is available
errors      every error, on one page
"""
