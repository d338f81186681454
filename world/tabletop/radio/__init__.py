"""The radio of robots on a table: it loses beacons as the channel of the scenario does.

reachability  reception probabilities at the true poses
relay         the fate of each datagram, and the counts
radio_socket  the socket of the relay
"""
