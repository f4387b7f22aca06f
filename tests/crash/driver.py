"""A driver that notes the points reported as done, and that can be made to err.

python -m tests.crash.driver LOG run SCENE -o OUT.zarr       # as the command irg
"""

import argparse
import json
import os
import sys
import time
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from unittest import mock

from pipeline import ExecutionError, StoreError, paths
from pipeline.cli import main as irg
from pipeline.run import run_sweep as running
from pipeline.run.drive import Tally
from pipeline.store import create
from pipeline.store import store as write
from pipeline.store.location import NEW, OLD, sibling
from pipeline.store.store import Store, Writer
from tests.crash.sweeps import record_of

GIVEN_UP = 2
"""Exit code of a driver that ends with a word."""


def drive(sweep, path, log, records=None, mistake=None, pace=0.0, source=None, fault=None):
    """Run or resume a sweep; return the exit code that the command would have.

    Without workers, `records` are what they would return by point, each task after `pace` [s].
    `fault` is a context that disturbs the disk.
    """
    with ExitStack() as stack:
        stack.enter_context(noting(log))
        stack.enter_context(MISTAKES[mistake]())
        stack.enter_context(computing(records, pace) if records else nullcontext())
        stack.enter_context(fault or nullcontext())
        try:
            outcome = running.run_sweep(sweep, path, workers=2, retry_failed=True, source=source)
        except (StoreError, ExecutionError) as error:
            print(error, file=sys.stderr)
            return GIVEN_UP
    return 1 if outcome.failed else 0


@contextmanager
def noting(log):
    """Context: write the points that are reported to callers as done to the file `log`."""
    count = Tally.count

    def noted(self, records, workers):
        records = list(records)
        with Path(log).open("a") as stream:
            stream.writelines(f"{json.dumps(r.point)}\n" for r in records if r.data is not None)
        count(self, records, workers)

    with mock.patch.object(Tally, "count", noted):
        yield


@contextmanager
def computing(records, pace, writes_each=True):
    """Context: "compute" points in this process from their records, and write each at once.

    If `writes_each` is False, all are written at the end.
    """

    watch = mock.Mock(**{"cpu_time.return_value": 0.0})

    def compute(link, watch, store, queue, tally):
        with Writer(store) as writer:
            while queue:
                writer.add([record_of(records, store.sweep, queue.take("here").point)])
                if writes_each or not queue:
                    tally.count(writer.flush(), 1)
                time.sleep(pace)

    with (
        mock.patch.object(running, "compute", compute),
        mock.patch.object(running, "connected", return_value=nullcontext(None)),
        mock.patch.object(running, "Watch", return_value=watch),
        mock.patch.multiple(write, _PAUSE=0.0, _SHARE=0.0),
    ):
        yield


def _status_first():
    write = Store.write

    def careless(self, where, values, states):
        write(self, where, {}, states)
        write(self, where, values, states)

    return mock.patch.object(Store, "write", careless)


def _unsynced():
    return mock.patch.object(paths.os, "fsync")


def _deleted():
    def careless(location):
        for ending in (NEW, OLD):
            create._remove_folder(sibling(location, ending))

    return mock.patch.object(create, "_remove_leftovers", careless)


MISTAKES = {
    None: nullcontext,
    "old store deleted": _deleted,
    "status first": _status_first,
    "unsynced": _unsynced,
}
"""Mistakes that the campaigns are there to notice."""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log")
    parser.add_argument("--mistake", choices=[name for name in MISTAKES if name])
    options, command = parser.parse_known_args()
    with noting(options.log), MISTAKES[options.mistake]():
        return irg(command)


if __name__ == "__main__":
    os.environ.setdefault("PYTHONPATH", str(Path(__file__).parents[2]))
    sys.exit(main())
