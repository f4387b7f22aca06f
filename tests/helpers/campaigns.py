"""Results of campaigns, with the code that they speak of."""

import json
import multiprocessing
import os
import shlex
import subprocess
import sys
import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from datetime import date
from itertools import islice
from pathlib import Path

ROOT = Path(__file__).parents[2]


def git(*arguments):
    """Output of a git command, without its last line break; empty if it fails."""
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def commit():
    """Short name of the checked-out commit, with "-dirty" if files differ."""
    return git("describe", "--always", "--dirty") or "unknown commit"


def table(columns, rows):
    """A Markdown table as text."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (columns, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(columns), *lines[1:]])


def save(name, text, is_right):
    """Write the text of a campaign to ``results``, with its command, date and commit."""
    module = sys.modules["__main__"].__spec__.name.removesuffix(".__main__")
    command = shlex.join(["python", "-m", module, *sys.argv[1:]])
    verdict = "right" if is_right else "not right"
    path = Path("results", f"{name}.md")
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"`{command}`: {verdict}; {date.today():%m-%d}, {commit()}\n\n{text}\n")


def conclude(name, text, is_right):
    """Print and save the text of a campaign; return the exit code, 0 if `is_right`."""
    save(name, text, is_right)
    print(text)
    return 0 if is_right else 1


def read(path):
    """Rows of a file of results, each a line of JSON."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def compute(function, tasks, path, minutes):
    """Append to a file the row of each task, on all cores; begin none after `minutes`."""
    end, running, tasks = time.monotonic() + 60 * minutes, set(), iter(tasks)
    processes = len(os.sched_getaffinity(0))
    context = multiprocessing.get_context("spawn")
    path.parent.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(processes, context) as pool, path.open("a") as file:
        while True:
            free = processes - len(running) if time.monotonic() < end else 0
            running |= {pool.submit(function, task) for task in islice(tasks, free)}
            if not running:
                return
            ready, running = wait(running, return_when=FIRST_COMPLETED)
            for row in (future.result() for future in ready):
                print(json.dumps(row), file=file, flush=True)
                summary = row["name"], f"{row['seconds']:.0f} s", row.get("failed", "")
                print(*summary, file=sys.stderr, flush=True)
