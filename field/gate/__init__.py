"""The gate: a process between the agent and the wheels. It stops the robot when the agent cannot.

rules       the rules of the gate, pure
link        frames between agent and gate
driver      the vendor's driver over Zenoh
operator    permits, start, stop and status
process     the gate's loop, and its end
__main__    the entry point of the gate's process
launch      the agent's end: start a gate, send commands, take poses
"""
