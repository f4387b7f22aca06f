"""A sweep, its points and their order."""
