"""Figures of a stored sweep: diagram, ramp, fields, and speed against accuracy."""
