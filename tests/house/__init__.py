"""Sizes of the code, the pages of reference, and rules that all files keep.

    python -m tests.house

prints the lines of code of each room.
"""
