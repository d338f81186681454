"""Figures, claims and studies.

command            the commands: fes plot and fes claims
history            a run as time series
run_events         its changes: of the channel, of the robots, of their hardware
figures            the paper's figures, and figures of a run
team_figures       figures of the team index
frames             the numbers of an animation, frame by frame
scene              the picture of a frame
animation          an animation as a GIF or MP4 file
claims             computations: errors in the paper's text
team_claims        computations: numbers of the team index
convergence_study  convergence of robots that count beacons, over seeds
step_study         integration error against the step
"""
