"""Kill the scenario before each change to its files, and see what is left.

Forks a process for each crash and another to look at the result; prints a JSON document.
"""

import argparse
import json
import os
import pickle
import shutil
import sys
import tempfile
import traceback
import warnings
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pint  # noqa: F401  xarray would import it in every process

from tests.crash import scenario
from tests.crash.bounded import add_seconds, until
from tests.crash.countdown import Countdown

_MEMORY = Path("/dev/shm")  # where an fsync takes no time


def forked(function, *arguments):
    """What a function gives in a process of its own; None if that is killed."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        try:
            with os.fdopen(writing, "wb") as pipe:
                pickle.dump(function(*arguments), pipe)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        answer = pipe.read()
    _, ended = os.waitpid(child, 0)
    if os.WIFEXITED(ended) and os.WEXITSTATUS(ended):
        sys.exit("a process ended with an error")
    return pickle.loads(answer) if os.WIFEXITED(ended) else None


def crash(folder, last, control):
    """Run the scenario; say how many changes it made, if it lived to see its end."""
    with (folder / "acknowledged").open("w") as log:

        def tell(how, point):
            log.write(json.dumps([how, point]) + "\n")
            log.flush()

        with scenario.status_first() if control else nullcontext():
            countdown = Countdown(folder / "store", last)
            scenario.run(folder / "store" / "out.zarr", tell)
    return countdown.changes


def look(folder, expected):
    """Faults of what a crash has left, and of what comes of it when the run is resumed."""
    path = folder / "store" / "out.zarr"
    log = (folder / "acknowledged").read_text().splitlines()
    try:
        faults = scenario.check(path, [json.loads(line) for line in log])
        scenario.resume(path)
        found = scenario.content(path)
        faults += [f"resumed, {name} differs" for name in expected if found[name] != expected[name]]
        faults += [f"left over: {left.name}" for left in path.rglob("*.partial")]
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="crash points to go on by")
    parser.add_argument("--status-first", action="store_true", help="make the mistake to find")
    parser.add_argument("--until-fault", action="store_true", help="stop at the first fault")
    add_seconds(parser)
    options = parser.parse_args()
    warnings.simplefilter("error")
    np.seterr(all="raise", under="ignore")
    scenario.results()
    with tempfile.TemporaryDirectory(dir=_MEMORY if _MEMORY.is_dir() else None) as temporary:
        folder = Path(temporary)
        (folder / "store").mkdir()
        changes = forked(crash, folder, None, False)
        expected = forked(scenario.content, folder / "store" / "out.zarr")
        faults = {}
        crashes = 0
        points = range((options.every + 1) // 2, changes + 1, options.every)
        for last in until(options.seconds, points):
            crashes += 1
            shutil.rmtree(folder / "store")
            (folder / "store").mkdir()
            if forked(crash, folder, last, options.status_first) is not None:
                faults[last] = ["it was not killed"]
            elif found := forked(look, folder, expected):
                faults[last] = found
            if faults and options.until_fault:
                break
            if sys.stderr.isatty():
                told = f"\r{crashes} of {len(points)}, {len(faults)} faulty"
                print(told, end="", file=sys.stderr)
    print(json.dumps({"changes": changes, "crashes": crashes, "faults": faults}, indent=1))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
