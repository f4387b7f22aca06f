"""Inputs that are not known exactly: probabilities, causes, measurements and the next test."""
