"""Rivals of the paper's law. Each uses only the public interface `fes.extension`.

fixed_separation  seeking law: a constant separation
krstic_wang       seeking law: classic extremum seeking per link, on counted beacons
gradient          formation law: gradient of the link quality, told the channel
alpha_lattice     formation law: flocking to a lattice, with velocity consensus
voronoi           formation law: coverage by Voronoi cells
connectivity      formation law: a potential that keeps links
"""
