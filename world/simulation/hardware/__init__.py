"""The robots' hardware in the world: sensors that err and come late, bodies that slip and lag.

normals    normally distributed numbers as a function of (seed, stream, tick, robot).
sensors    fixes of the poses: their noise, rate and age.
actuators  the twists that bodies make of their commands.
"""
