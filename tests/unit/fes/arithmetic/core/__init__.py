"""The compiled elementary functions against numpy's, to the bit."""
