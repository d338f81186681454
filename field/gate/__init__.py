"""The gate: a process between the agent and the wheels. It stops the robot when the agent cannot.

settings    everything that the gate of one robot needs, to and from JSON
frames      body frame and team frame, and the scale between them
fence       the polygon that a robot must not leave, and the braking distance before it
motion      a check that the pose moves as commanded
pose_guard  the rules that a pose must keep
gate        events and the time in, a bounded twist out; the table of causes
link        frames between agent and gate
driver      the vendor's driver over Zenoh
operator    permits, start, stop and status
process     the gate's loop, and its end
__main__    the entry point of the gate's process
launch      the agent's end: start a gate, send commands, take poses
"""
