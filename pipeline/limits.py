"""Limits that several files share, so that a small scene or store cannot take all memory."""

MAX_ON_AXIS = 5000
"""Most loads or velocities, and rows of `along`, which `irg check` reads in some 4 s."""
MAX_CASES = 10_000
"""Most combinations of `over`, tests or surfaces: each is a scene, read in 0.5 ms."""
MAX_VARIED_ENTRIES = 100
"""Most entries that vary in a sweep."""
MAX_POINTS = 10_000_000
"""Most points of a sweep."""
MAX_INPUTS = 2**26
"""Most numbers of a scene's files in a store: four of the largest scans."""
MAX_HINTS = 20
"""Most unknown keys for which similar ones are looked up."""
