"""Answers from a stored sweep: labelled dataset, boundary, margins and their errors."""
