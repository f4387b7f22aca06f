"""Sizes of the code: two sums that only fall, printed by room.

    python -m tests.house

prints them. At the end of an issue its author writes the sums of that day into `sums.toml`.
"""
