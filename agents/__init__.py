"""A robot: its laws, its control step and its process.

laws           neighbor rules, formation, seeking, packet counting, the oracle: pure
configuration  the formation law of a team that takes up one configuration: pure
rivals         laws of other authors, for comparison
control        one step of a crew from what it sensed and heard: pure
core           the same step as one call of the compiled core
runtime        asyncio and Zenoh: ticks in, beacons and commands out
process        the process fes-agent
__main__       entry point of fes-agent
"""
