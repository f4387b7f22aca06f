"""Let several processes write points that share chunks, and kill or stop them at random.

Each takes some of the points that are left, in an order of its own and some of them together, as
others do at the same time; now and then it calls one failed, as a driver may. What was acknowledged
must be done, stay done, and be what was computed, bit for bit; in the end all points are, and no
lock is left. Prints a JSON document.
"""

import argparse
import json
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager, nullcontext
from pathlib import Path
from unittest import mock

import numpy as np

from pipeline.store import DONE, Store, StoreError, locked, prepare, verify_store
from pipeline.store import points as store_points
from pipeline.sweep.plan import points, run_point
from tests.crash.bounded import add_seconds, until
from tests.crash.compared import differing
from tests.helpers import tiny

SWEEP = tiny.full(velocities=tuple(np.linspace(0.5, 1.5, 12).tolist()))
WRITERS = 4
PATIENCE = 60.0  # [s] for all points, which take less than 5
_PROCESSES = multiprocessing.get_context("fork")


def write(store, results, told, seed):
    """Commit points until all are done."""
    chance = random.Random(seed)
    order = chance.sample(list(results), len(results))
    while order:
        own = [order.pop() for _ in range(min(len(order), chance.randint(1, 6)))]
        try:
            if chance.random() < 0.2:
                store.fail(own[0], "as a driver may believe")
            store.commit(*(results[point] for point in own))
        except StoreError as error:
            told.send(str(error))
            return
        told.send(own)


def heard(receivers):
    """Points that were acknowledged since, and errors."""
    said = []
    for receiver in receivers:
        try:
            while receiver.poll():
                said.append(receiver.recv())
        except (EOFError, OSError):  # killed in the middle of a word
            pass
    errors = [each for each in said if isinstance(each, str)]
    return [point for each in said if not isinstance(each, str) for point in each], errors


class Round:
    """Processes that write to one store, and what they have said."""

    def __init__(self, path, results, chance):
        self.store, self.results, self._chance = Store(path), results, chance
        self.acknowledged, self.faults, self.did = set(), [], Counter()
        self._writers = []

    def start(self):
        receiver, sender = _PROCESSES.Pipe(duplex=False)
        arguments = (self.store, self.results, sender, self._chance.random())
        writer = _PROCESSES.Process(target=write, args=arguments)
        writer.start()
        sender.close()
        self._writers.append((writer, receiver))

    def disturb(self):
        """Kill a process, or stop it for a moment."""
        writer, _ = self._chance.choice(self._writers)
        if self._chance.random() < 0.3:
            self.did["stopped"] += 1
            os.kill(writer.pid, signal.SIGSTOP)
            time.sleep(self._chance.uniform(0.0, 0.1))
            os.kill(writer.pid, signal.SIGCONT)
        else:
            self.did["killed"] += 1
            writer.kill()

    def look(self):
        """Compare what is in the store with what was acknowledged; go on with live processes."""
        said, errors = heard([receiver for _, receiver in self._writers])
        self.acknowledged |= {*said}
        self.faults += errors
        flags = self.store.status()
        self.faults += [f"{at} is not done" for at in self.acknowledged if flags[at] != DONE]
        done = [point for point, flag in flags.items() if flag == DONE]
        self.faults += [f"{at} differs" for at in done if differing(self.store, self.results[at])]
        for writer, receiver in [each for each in self._writers if not each[0].is_alive()]:
            writer.join()
            said, errors = heard([receiver])
            self.acknowledged |= {*said}
            self.faults += errors
            receiver.close()
            self._writers.remove((writer, receiver))
        return len(done) == len(self.results) and not self._writers

    def run(self):
        """Write all points, disturbed until they are there."""
        end = time.monotonic() + PATIENCE
        for _ in range(WRITERS):
            self.start()
        while not self.look() and not self.faults:
            if time.monotonic() > end:
                self.faults.append(f"not all points are done within {PATIENCE:g} s")
                break
            if self._writers and len(self.acknowledged) < len(self.results):
                self.disturb()
            while len(self._writers) < WRITERS and len(self.acknowledged) < len(self.results):
                self.start()
            time.sleep(self._chance.uniform(0.0, 0.05))
        for writer, _ in self._writers:
            writer.kill()
            writer.join()


@contextmanager
def unlocked():
    """Stores that make the mistake to find: they write to shared chunks without a lock."""
    with mock.patch.object(store_points, "part_held", return_value=nullcontext()):
        yield


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--unlocked", action="store_true", help="make the mistake to find")
    add_seconds(parser)
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    results = {point: run_point(SWEEP, *point) for point in points(SWEEP)}
    report = {"rounds": 0, "did": Counter(), "faults": []}
    with unlocked() if options.unlocked else nullcontext():
        for number in until(options.seconds, range(options.rounds), options.seed):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "out.zarr"
                with locked(path):
                    prepare(path, SWEEP)
                this = Round(path, results, random.Random(f"{options.seed} {number}"))
                this.run()
                with locked(path):
                    pass
                report["faults"] += this.faults
                if not verify_store(path).is_clean:
                    report["faults"].append(f"round {number}: the store is damaged")
                if left := [file.name for file in Path(folder).iterdir() if file != path]:
                    report["faults"].append(f"round {number}: left over: {left}")
            report["rounds"] += 1
            report["did"] += this.did
            if report["faults"]:
                break
    print(json.dumps(report, indent=1))
    return 1 if report["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
