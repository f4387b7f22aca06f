"""What is to be simulated: a sweep, its points and their order."""
