"""The rules of the gate, without a process or a network. Pure.

settings    everything that the gate of one robot needs, to and from JSON
frames      body frame and team frame, and the scale between them
fence       the polygon that a robot must not leave, and the braking distance before it
motion      a check that the pose moves as commanded
pose_guard  the rules that a pose must keep, and the fence
permits     the operator's permission to move
state       the state of a gate, and a command from the agent
gate        events and the time in, a bounded twist out; the table of causes
"""
