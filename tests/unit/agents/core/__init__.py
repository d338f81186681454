"""The compiled kernels of the robots against numpy's, to the bit."""
