"""Figures, claims and studies.

command            the commands fes plot and fes claims
history            a run as time series
figures            the paper's figures, and those of a run
claims             where the paper's text does not hold, as computations
convergence_study  how robots that count beacons find the optimum, over seeds
step_study         how the integration error depends on the step
"""
