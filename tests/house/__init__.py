"""Sizes of the rooms, which a test compares with the numbers in `sizes.toml`.

    python -m tests.house

writes those of today into that file; a commit in which one rises names the file and says why.
"""
