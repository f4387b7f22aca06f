"""Print the lines of code of each room."""

from tests.sources.measure import lines_by_room

for name, size in sorted(lines_by_room().items()):
    print(f"{size:7d}  {name}")
