"""The compiled core of the world: its whole tick in C, to the bits of `world.simulation`.

compiled_world  a world whose tick is one call.
message_reader  the beacons or the commands of a tick, read in one call.
structures      the structures of the C code, and the places of the arrays in a buffer.
self_test       the test of the library when it is loaded.
"""
