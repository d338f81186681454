"""The compiled core of the world, to the bits of numpy: its tick, the errors of links, the messages that it reads.

compiled_world  a world whose tick is one call.
link_kernels    separations and errors of the robots' links.
message_reader  the beacons or the commands of a tick, read in one call.
stored_radio    the radio in a buffer, whose arrays are made when they are read.
structures      the structures of the C code, and the places of the arrays in a buffer.
self_test       the test of the library when it is loaded.
"""
