"""Figures of a stored sweep: diagram, ramp, fields, tests, and speed against accuracy."""
