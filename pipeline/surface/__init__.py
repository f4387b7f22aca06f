"""Measured surfaces: what a scan says in numbers, and what a scene takes of it."""
