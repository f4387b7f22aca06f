"""Measured surfaces: scans, and the windows of them that a scene simulates."""
