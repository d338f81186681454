"""Claims about the laws and the machinery, each with an independent witness."""
