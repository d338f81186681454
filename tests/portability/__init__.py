"""One digest under every processor and library."""
