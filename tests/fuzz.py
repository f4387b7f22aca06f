"""Files of users, mutated: each is read, or refused in a line, within some seconds and megabytes.

    python -m tests.fuzz --minutes 3 --seed 1

Scans, tables and scenes get bytes changed, cut out, put in and doubled. Prints a JSON document with
the numbers of files of each kind that were read and refused, and the faults. A file at fault stays
in results/fuzz.
"""

import argparse
import collections
import json
import random
import resource
import time
import warnings
from pathlib import Path

import numpy as np

from pipeline import load_scene
from pipeline.surface import scan, window
from pipeline.table import read_table
from tests.helpers.campaigns import conclude
from tribo import TriboError

WORKFLOWS = Path(__file__).parents[1] / "workflows"
LEFT = Path("results/fuzz")
SECONDS, MEGABYTES, LETTERS = 5.0, 1000, 2000  # of CPU for a file, of this process, of a message
WORDS = (b"nan", b"inf", b"-9999", b"1e400", b"\n\n", b",,", b"\0", b"#", b"1e9", b'"', b"[", b"=")


def scans():
    """Scans of each kind, by file name."""
    heights = np.random.default_rng(5).normal(0.0, 3e-7, (30, 24))
    rows = [[f"{1e6 * z:.4f}" for z in row] for row in heights.T]
    text = "\n".join(map(" ".join, rows))
    head = "# Channel: z\n# Width: 15 um\n# Height: 24 um\n# Value units: um\n"
    return {
        "a.npy": (WORKFLOWS / "scan.npy").read_bytes(),
        "a.csv": "\n".join(map(",".join, rows)).encode(),
        "head.txt": (head + text).encode(),
        "grid.asc": f"ncols 30\nnrows 24\ncellsize 0.5\n{text}".encode(),
    }


def read_scan(path, rng):
    window.filled(scan.read_scan(path, 1e-6)[0], 0.1)


def tables():
    """Tables in several dialects, by file name."""
    rows = [("load [N]", "velocity [m/s]", "friction", "name")]
    rows += [(f"{100 + k}.5", f"{1 + 0.1 * k:.2f}", "0.1", f"run {k}") for k in range(20)]
    text = "\n".join(map(",".join, rows))
    return {
        "a.csv": text.encode(),
        "b.csv": text.replace(",", ";").replace(".", ",").encode("cp1252"),
        "c.txt": text.replace(",", "\t").encode("utf-16"),
    }


def read_rows(path, rng):
    sheet = read_table(path, 1000, rng.choice([None, ".", ","]))
    sheet.rows(("load", "velocity", "friction"), lambda row: (), ("load",))


def scenes():
    """Shipped scenes, by file name."""
    names = ("irg_transition", "scan", "oil_a", "twin_disc")
    return {f"{name}.toml": (WORKFLOWS / f"{name}.toml").read_bytes() for name in names}


def read_scene(path, _):
    load_scene(path).all_warnings  # noqa: B018


KINDS = {"scan": (scans, read_scan), "table": (tables, read_rows), "scene": (scenes, read_scene)}


def mutated(content, rng):
    """The content with one change of a random kind."""
    data, at = bytearray(content), rng.randrange(len(content))
    match rng.randrange(7):
        case 0:
            for _ in range(rng.choice([1, 3, 30])):
                data[rng.randrange(len(data))] = rng.randrange(256)
        case 1:  # near the beginning, where sizes are
            for _ in range(rng.choice([1, 2, 8])):
                data[rng.randrange(min(400, len(data)))] = rng.choice(b"\0\xff\x7f019.-,")
        case 2:
            del data[at:]
        case 3:
            del data[at : at + rng.choice([1, 2, 7, 100])]
        case 4:
            data[at:at] = rng.choice(WORDS) * rng.choice([1, 1, 5000])
        case 5:
            other = rng.randrange(len(data))
            data[at:at] = data[other : other + 200]
        case 6:
            data += bytes(data)
    return bytes(data)


def fault_of(read, path, rng):
    """What a reader did with a file, and what is wrong with that; empty if nothing is."""
    began, done, fault = time.process_time(), "read", ""
    try:
        read(path, rng)
    except TriboError as error:
        done = "refused"
        fault = "a long message" * (len(str(error)) > LETTERS)
    except Exception as error:
        done, fault = "raised", f"{type(error).__name__}: {error}"[:300]
    if (seconds := time.process_time() - began) > SECONDS:
        fault = fault or f"{seconds:.1f} s"
    if (size := resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3) > MEGABYTES:
        fault = fault or f"{size:.0f} MB"
    return done, fault


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    warnings.simplefilter("error")
    np.seterr(all="raise", under="ignore")
    rng, faults, counts = random.Random(options.seed), {}, collections.Counter()
    files = [
        (kind, read, *file) for kind, (build, read) in KINDS.items() for file in build().items()
    ]
    LEFT.mkdir(parents=True, exist_ok=True)
    (LEFT / "scan.npy").write_bytes((WORKFLOWS / "scan.npy").read_bytes())  # named by a scene
    for kind, read, name, content in files:  # whole, each is read; libraries are imported
        path = LEFT / name
        path.write_bytes(content)
        done, fault = fault_of(read, path, rng)
        counts[f"{kind} {done}, unchanged"] += 1
        if fault and not fault.endswith(" s"):
            faults[name] = fault
    end = time.monotonic() + 60 * options.minutes
    while time.monotonic() < end:
        kind, read, name, content = rng.choice(files)
        path = LEFT / f"{counts.total()}_{name}"
        path.write_bytes(mutated(content, rng))
        done, fault = fault_of(read, path, rng)
        counts[f"{kind} {done}"] += 1
        if fault:
            faults[str(path)] = fault
        else:
            path.unlink()
    document = {"files": counts.total(), **counts, "faults": faults}
    return conclude("fuzz", json.dumps(document, indent=1), not faults)


if __name__ == "__main__":
    raise SystemExit(main())
