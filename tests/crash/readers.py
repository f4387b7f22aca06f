"""Read a store again and again while it is compacted, split and grown in another process.

Every reader sees the points as they were committed, or a clear word. Prints a JSON document.
"""

import argparse
import itertools
import json
import multiprocessing
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
from pipeline.store.variables import COLUMNS

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import open_sweep
from pipeline.store import (
    BY_POINT,
    COMPACT,
    StoreError,
    lay_out,
    locked,
    prepare,
    summary,
    verify_store,
)
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny

SWEEP = tiny.full(velocities=(0.5, 1.0, 1.5, 4.0))


def rewritten(path, end):
    """Compact, split and grow a store until some time."""
    for number in itertools.count():
        if time.monotonic() > end:
            return
        with locked(path):
            lay_out(path, COMPACT)
            lay_out(path, BY_POINT)
            if number % 10 == 9:
                further = 2.0 + number / 1000
                prepare(path, tiny.full(velocities=(*SWEEP.velocities[:-1], further, 4.0)))
                prepare(path, SWEEP)


def seen(path, what):
    """What a reader sees of the points of the sweep."""
    if what == "summary":
        return summary(path).done
    if what == "verify":
        found = verify_store(path)
        return found.done, found.damaged
    with open_sweep(path) as ds:
        own = ds.sel(load=list(SWEEP.loads), velocity=list(SWEEP.velocities))
        if what == "boundary":
            return str(
                boundary(own).as_dict() if hasattr(boundary(own), "as_dict") else boundary(own)
            )
        return {name: own[name].values.tobytes() for name in (*COLUMNS, "status", "pressure")}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    reads, words, faults = Counter(), Counter(), []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "out.zarr"
        with locked(path):
            store = prepare(path, SWEEP)
            for point in points(SWEEP):
                store.commit(run_point(SWEEP, *point))
        kinds = ("summary", "verify", "boundary", "data")
        expected = {what: seen(path, what) for what in kinds}
        end = time.monotonic() + options.seconds
        writer = multiprocessing.get_context("spawn").Process(target=rewritten, args=(path, end))
        writer.start()
        for what in itertools.cycle(kinds):
            if time.monotonic() > end:
                break
            try:
                found = seen(path, what)
            except StoreError as error:
                words[str(error).rpartition(": ")[2]] += 1
                continue
            reads[what] += 1
            if found != expected[what]:
                faults.append(f"{what} differs: {found!r:.200}")
        writer.join(60.0)
        if writer.exitcode is None:
            writer.kill()
            writer.join()
    print(json.dumps({"reads": reads, "refused": words, "faults": faults[:10]}, indent=1))
    return 1 if faults or writer.exitcode else 0


if __name__ == "__main__":
    sys.exit(main())
