"""The radio of a robot: authenticated beacons by UDP multicast, or by a relay.

settings       RadioSettings: the network and the team's key.
socket         Radio: the socket that sends and receives beacons.
replay_window  protection from replayed datagrams: pure.
wall_clock     the wall clock against the monotonic clock.
counters       datagrams sent, heard and refused.
"""
