"""Metrics of the whole team's configuration.

coverage  area that the robots cover
delivery  delivery between all robots, also after the worst loss of one
"""
