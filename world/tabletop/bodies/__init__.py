"""Bodies of robots on a table.

interface      the interface of a team of bodies
team           the bodies of a scenario; the scale between the table and the law
kinematic      bodies that follow their commands exactly
mujoco_model   the model of wheels, motors and floor, as MJCF
mujoco_bodies  bodies in MuJoCo
"""
