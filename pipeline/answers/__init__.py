"""Answers from a stored sweep: the boundary, operating points, tests. Each is a dataset."""
