"""Results over many seeds.

measured  robots that count beacons: the table of docs/measured.md, some minutes
"""
