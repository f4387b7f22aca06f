"""Inputs that are not known exactly: probabilities, causes and measurements."""
