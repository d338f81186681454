"""Results over many seeds.

measured  robots that count beacons: the table of docs/explanation/counting-beacons.md, within minutes
noise     robots with noisy, slow and late poses: the table of docs/explanation/noise.md
"""
