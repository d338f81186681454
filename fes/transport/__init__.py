"""Zenoh: one session per process, and the way of its samples to asyncio.

bus                   everything that a session declares
foreign               keys of programs that are not ours, such as ROS 2 nodes
session               how a session is opened
inbox                 from Zenoh's threads to the loop, one wake-up per tick
network_flags         flags that say how a program reaches a run
endpoints             how a process takes part in the network
addresses             rules of an endpoint's address, and names that do not resolve
identity              certificates: the role of a process
connection_diagnosis  the reason why a session did not open
drop_log              rejected and missing messages: counted, and logged once per kind
health                health checks: a port with a listener, or an open connection
"""
