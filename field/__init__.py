"""A robot in the real world: its body, its gate, its radio and its senses instead of a simulated world.

gate  the process between the agent and the wheels
"""
