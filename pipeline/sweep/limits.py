"""What a scene, a workbook or a table may ask for, so that a small file cannot take the memory."""

MOST_ON_AXIS = 5000
"""Loads or velocities of a range: `irg check` looks at each, in 3 s of processor time in all."""
MOST_SCENES = 10_000
"""Combinations of `over`, places of `along`, or surfaces; each is a scene, read in 0.5 ms."""
MOST_POINTS = 10_000_000
"""Points that a sweep may have."""
MOST_BYTES_OF_BOOK = 10_000_000
"""Bytes that a workbook may unpack to: some 300 000 cells, each an object of 100 bytes and more."""
MOST_CELLS_OF_SHEET = 1_000_000
"""Cells of a sheet up to the last one, since all before it are read, though they be empty."""
MOST_BYTES_OF_TEXT = 100_000_000
"""Bytes of a table in text: some ten million cells, each an object of 60 bytes."""
