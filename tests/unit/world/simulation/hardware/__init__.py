"""The robots' hardware in the world against moments, differential equations and its rules of time."""
