"""The compiled core of the robots: a crew's whole tick in C, to the bits of `agents.control` and `agents.laws`.

compiled_crew   a crew whose tick is one call.
byte_crew       the same, from the bytes of messages to the bytes of answers.
payload_writer  the messages of a tick of a crew that arrays move, as bytes.
buffer          the buffer of a state, and conversion from and to numpy.
constants       the constants of a crew for the core, where the core has its laws.
structures      the structures of the C code.
self_test       the test of a library when it is loaded.
"""
