"""Measured surfaces: statistics of a scan, and the windows of it that a scene simulates."""
