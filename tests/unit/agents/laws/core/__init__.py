"""The compiled index of the oracle against numpy's, to the bit."""
