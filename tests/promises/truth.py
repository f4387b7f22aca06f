"""Rises by `reference` at places of the campaign's scenes, computed once and kept.

``truth.json`` has a line for each scene, by the digest of its entries: whoever changes a scene
computes it anew. A velocity is written when its loads are done.

    python -m tests.promises.truth --minutes 60
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.promises.families import cases
from tribo import TriboError, judge
from tribo.simulation import RampCache

TRUTH = Path(__file__).with_name("truth.json")


def verdicts(sweep, velocity):
    """Verdict at each load of a sweep, at one velocity."""
    ramp_cache = RampCache()
    return [
        judge(sweep.scene, load, velocity, sweep.conditions, ramp_cache) for load in sweep.loads
    ]


def deciding_rise(verdict, conditions):
    """Deciding rise [K] of a verdict at friction 1."""
    return (verdict.governing_temperature - verdict.bulk_temperature) / conditions.friction


def known(case):
    """Known true rises [K] of a scene, by velocity as text."""
    return _read().get(case.digest, {})


def _read():
    return json.loads(TRUTH.read_text()) if TRUTH.exists() else {}


def _write(case, rises):
    """Save the true rises of a scene, in a line of the file."""
    scenes = _read() | {case.digest: rises}
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in sorted(scenes.items())]
    TRUTH.write_text("{\n" + ",\n".join(lines) + "\n}\n")


def compute(case, ends):
    """Compute missing true rises of a scene, until the time `ends`."""
    rises = known(case)
    with tempfile.TemporaryDirectory() as folder:
        sweep = case.sweep(Path(folder))
    for velocity in sweep.velocities:
        key = f"{velocity:g}"
        if key in rises or time.monotonic() > ends:
            continue
        began = time.process_time()
        points, conditions = verdicts(sweep, velocity), sweep.conditions
        rises[key] = [float(f"{deciding_rise(point, conditions):.8g}") for point in points]
        _write(case, rises)
        took = time.process_time() - began
        print(f"{case.name}, {velocity:g} m/s: {took:.0f} s", file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.truth", description=__doc__)
    parser.add_argument("--numbers", type=int, default=16, help="scenes of each family")
    parser.add_argument("--minutes", type=float, default=600.0, help="begin no velocity later")
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    ends = time.monotonic() + 60 * options.minutes
    for case in cases(range(options.numbers)):
        try:
            compute(case, ends)
        except TriboError as error:
            print(f"{case.name} failed: {error}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
