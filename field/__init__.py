"""A robot in the real world: its body, its gate, its radio and its senses instead of a simulated world.

settings  robot.toml
gate      a small process between the law and the wheels
radio     the socket of the beacons
senses    an Observation from what was heard: pure
runtime   ticks, fixes, steps and reports
process   the process fes-robot
__main__  entry point of fes-robot
"""
