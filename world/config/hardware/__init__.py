"""Settings of emulated hardware.

tabletop  a scenario's table [tabletop]: a team of small robots on a table
"""
