"""The compiled tick of the world against numpy's, to the bit."""
