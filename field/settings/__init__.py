"""robot.toml: the settings of a real robot, or of a team of them.

robot_file  the file, and the settings of the laws in it
body        its tables [body], [limits] and [team]: the driver, its frame, the gate
for_gate    the settings of its gate
radio       its table [radio]: the network of the beacons
"""
