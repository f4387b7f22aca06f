"""Print the sizes of today, and the sums that they may not exceed."""

from tests.house.measure import allowed, data_files, lines_by_room, sums

limits = allowed()
for name, size in sums().items():
    print(f"{size:7d}  {name}, at most {limits[name]}")
for title, sizes in (("lines of code", lines_by_room()), ("lines of data files", data_files())):
    print(f"\n{title}")
    for name, size in sorted(sizes.items()):
        print(f"{size:7d}  {name}")
