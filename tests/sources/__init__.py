"""Sizes of the code, the pages of reference, and rules that all files keep.

    python -m tests.sources

prints the lines of code of each room.
"""
