"""Change one operator, number or condition at a time, and see whether a test turns red.

Places are drawn at random, room by room in turn, until the time is up. What was found is kept in a
file, a line for each mutant, and the next run goes on from there. The code is changed in a copy.
Survivors that `harmless.txt` lists, with the reason, are not reported.
"""

import argparse
import difflib
import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[2]
HARMLESS = Path(__file__).parent / "harmless.txt"
# Folders of modules to change; their examples and the tests that mirror them are run then.
ROOMS = [
    *(
        f"tribo/{room}"
        for room in ("contact", "loading", "simulation", "surface", "thermal", "wear")
    ),
    *(f"pipeline/{room}" for room in ("analysis", "scene", "store", "sweep", "tradeoff")),
    "pipeline/uncertain",
]
# Annotations are the only place where most modules write `|`; decorators and the like keep results.
_LEFT_OUT = ("core/RemoveDecorator", "core/Variable", "core/ReplaceBinaryOperator_BitOr")


def mutants(module, rng):
    """One change at each place of a module where there is any, in random order."""
    source = (ROOT / module).read_text()
    tree = get_ast(source)
    places = defaultdict(list)
    for name in operator_names():
        if name.startswith(_LEFT_OUT) or get_operator(name).arguments():
            continue
        operator = get_operator(name)()
        positions = (
            position for node in ast_nodes(tree) for position in operator.mutation_positions(node)
        )
        for occurrence, (begin, _) in enumerate(positions):
            places[begin].append((name, occurrence))
    chosen = [rng.choice(changes) for _, changes in sorted(places.items())]
    rng.shuffle(chosen)
    for name, occurrence in chosen:
        changed = mutate_code(source, get_operator(name)(), occurrence)
        if changed and changed != source and not change_of(source, changed)[-1].startswith("+@"):
            yield source, changed


def in_turn(seed, rooms):
    """Room, module and change; each room as often as the others, as long as it has any."""
    rng = random.Random(seed)
    queues = []
    for room in rooms:
        files = [file.relative_to(ROOT) for file in sorted((ROOT / room).rglob("*.py"))]
        rng.shuffle(files)
        queues.append(alternating([in_module(room, file, rng) for file in files]))
    return alternating(queues)


def in_module(room, file, rng):
    for change in mutants(file, rng):
        yield room, file, change


def alternating(iterables):
    """The first of each, the second of each, and so on until all have ended."""
    rows = itertools.zip_longest(*iterables)
    return (entry for row in rows for entry in row if entry is not None)


def is_red(copy, room, seconds=None):
    """True if a test of a room fails on the code in the copy."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"]
    command += [f"tests/{room}", room]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    process = subprocess.Popen(command, cwd=copy, env=environment, start_new_session=True, **quiet)
    try:
        return process.wait(timeout=seconds) != 0
    except subprocess.TimeoutExpired:
        return True  # a loop without an end is noticed, too
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def is_noticed(copy, room, module, changed, seconds):
    """True if a test fails on the change; the code is put back."""
    file = copy / module
    source = file.read_text()
    try:
        file.write_text(changed)
        return is_red(copy, room, seconds)
    finally:
        file.write_text(source)


def change_of(source, changed):
    """The lines that differ, as the report and the list of harmless ones have them."""
    lines = difflib.unified_diff(source.splitlines(), changed.splitlines(), n=0, lineterm="")
    return [line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---")]


def report(rows):
    """Print the number of changes that were noticed, and those that were not."""
    harmless = HARMLESS.read_text()
    for room in ROOMS:
        outcomes = Counter(row["noticed"] for row in rows if row["room"] == room)
        print(f"{room:18} {outcomes[True]} of {outcomes.total()} noticed")
    for row in rows:
        if not row["noticed"] and row["change"][-1] not in harmless:
            print("", f"not noticed: {row['module']}", *row["change"], sep="\n  ")


def main():
    """Go on with the campaign, then report."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no mutant later")
    parser.add_argument("--seconds", type=float, default=300.0, help="longest that tests may take")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rooms", nargs="+", choices=ROOMS, default=ROOMS)
    parser.add_argument("--file", type=Path, default=ROOT / "results" / "mutants.jsonl")
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    copy = options.file.with_suffix(".copy")
    shutil.rmtree(copy, ignore_errors=True)
    leave_out = shutil.ignore_patterns(".*", "results", "__pycache__")
    shutil.copytree(ROOT, copy, ignore=leave_out)
    rows = []
    if options.file.exists():
        rows = [json.loads(line) for line in options.file.read_text().splitlines()]
    changes = {(row["module"], *row["change"]) for row in rows}
    for room in options.rooms:
        if is_red(copy, room):
            sys.exit(f"the tests of {room} fail on the code as it is")
    began = time.monotonic()
    for room, module, (source, changed) in in_turn(options.seed, options.rooms):
        change = change_of(source, changed)
        if (str(module), *change) in changes:
            continue
        if time.monotonic() - began > 60 * options.minutes:
            break
        noticed = is_noticed(copy, room, module, changed, options.seconds)
        row = {"room": room, "module": str(module), "change": change, "noticed": noticed}
        rows.append(row)
        with options.file.open("a") as file:
            file.write(json.dumps(row) + "\n")
    shutil.rmtree(copy)
    report(rows)


if __name__ == "__main__":
    main()
