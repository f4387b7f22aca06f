"""Limits of a scene or a table, so that a small file cannot take all memory."""

MOST_ON_AXIS = 5000
"""Most loads or velocities, and rows of `along`, which `irg check` reads in some 4 s."""
MOST_SCENES = 10_000
"""Most combinations of `over`, tests or surfaces: each is a scene, read in 0.5 ms."""
MOST_VARIED = 100
"""Most entries that vary in a sweep."""
MOST_POINTS = 10_000_000
"""Most points of a sweep."""
MOST_INPUTS = 2**26
"""Most numbers of a scene's files in a store: four of the largest scans."""
MOST_ROWS = 1_000_000
"""Most rows of a table in text, which are read within a minute."""
MOST_OPERATING_POINTS = 100_000
"""Most operating points of a table, which are judged within a minute."""
MOST_BYTES_OF_SCENE = 1_000_000
"""Most bytes of a scene file and those that it extends, which are parsed in half a second."""
MOST_ENTRIES = 10_000
"""Most entries of a scene outside of lists: materials have six each."""
MOST_PARTS_OF_KEYS = 100_000
"""Most points and opening brackets outside of quotes in a scene, each a table of 1 kB at worst."""
MOST_LEVELS = 10
"""Most tables in tables of a scene, more than the format has."""
MOST_WITHOUT = 1000
"""Most entries that a scene leaves out of the one that it extends."""
MOST_FAULTS = 100
"""Most faults of a scene that are listed; from then on the scene is not read further."""
MOST_HINTS = 20
"""Most unknown keys for which similar ones are looked up."""
MOST_EXTENDED = 20
"""Most scenes that extend one another."""
MOST_BYTES_OF_TEXT = 40_000_000
"""Most bytes of a table in text: 40 in each of the most rows."""
MOST_BYTES_OF_LINE = 100_000
"""Most bytes of a line of a table."""
MOST_COLUMNS = 1000
"""Most columns of a table."""
MOST_CELLS_OF_TEXT = 5_000_000
"""Most cells of a table in text, each an object of 60 bytes."""
MOST_BYTES_OF_BOOK = 10_000_000
"""Most bytes of a workbook, also when it is unpacked."""
MOST_PARTS_OF_BOOK = 1000
"""Most files in a workbook: two for each sheet or figure."""
MOST_MARKS_OF_SHEETS = 120_000
"""Most tags and attributes in the sheets of a workbook: about six for each cell."""
MOST_MARKS_OF_STYLES = 30_000
"""Most tags and attributes in the other parts of a workbook, which take five times as long."""
MOST_CELLS_OF_SHEET = 1_000_000
"""Most cells of a sheet; empty cells before the last filled one count, since they are read."""
MOST_BYTES_OF_ROOT = 10_000_000
"""Most bytes of a document of a store. 5000 rows with six entries take 2.5 MB."""
MOST_MARKS_OF_ROOT = 600_000
"""Most brackets and commas in a document of a store: 5000 rows with six entries take 220 000."""
