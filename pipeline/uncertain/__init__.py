"""Inputs that are not known exactly: their samples, probabilities, sensitivities and posterior."""
