"""Results over many seeds.

measured  robots that count beacons: the table of docs/explanation/counting-beacons.md, within minutes
"""
