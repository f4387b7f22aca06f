"""What the commits of points take, beside files of the same sizes that are only written."""

import itertools
import os
import time
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.store.create import writing
from pipeline.sweep.plan import points
from tests.benchmarks.bare import shortest
from tests.helpers.points import run_point

AT_ONCE = 30  # points of a commit
PLANE = {
    "without": ["tests"],
    "sweep.loads": [f"{load:g} N" for load in np.linspace(200, 750, 12)],
    "sweep.velocities": [f"{velocity:g} m/s" for velocity in np.linspace(0.5, 5, 10)],
}


def time_of_bare_files(store, folder):
    """CPU time [s] to create, sync and rename a file for each chunk of a store."""
    sizes = [file.stat().st_size for file in store.rglob("c.*")]
    folder.mkdir()
    numbers = itertools.count()

    def write():
        for size in sizes:
            name = folder / f"{next(numbers)}"
            with name.with_suffix(".partial").open("wb") as file:
                file.write(bytes(size))
                file.flush()
                os.fsync(file.fileno())
            name.with_suffix(".partial").rename(name)

    return shortest(write)


@pytest.mark.parametrize("fields", [False, True], ids=["plain", "fields"])
def test_commits_of_120_points(benchmark, tmp_path, fields):
    sweep = pipeline.load_scene("irg_transition", "standard", PLANE | {"sweep.fields": fields})
    todo = sorted(points(sweep), key=lambda point: (point.velocity, point.load))
    record = run_point(sweep, todo[7]).record(fields)
    records = [replace(record, point=point, wall_time=0.1) for point in todo]
    took = []

    def commit_all():
        path = tmp_path / f"{len(took)}.zarr"
        with writing(path, sweep) as store:
            store.commit(records[:1])  # so that imports are not timed
            began = time.process_time()
            for first in range(1, len(records), AT_ONCE):
                store.commit(records[first : first + AT_ONCE])
            took.append(time.process_time() - began)

    benchmark.pedantic(commit_all, rounds=3)
    store = tmp_path / "0.zarr"
    files = sum(len(names) for _, _, names in os.walk(store))
    bare = time_of_bare_files(store, tmp_path / "bare")
    each = 1e3 * min(took) / (len(records) - 1)
    print(f"\n{each:.2f} ms of CPU a point, {files} files, {min(took) / bare:.1f} times bare files")
