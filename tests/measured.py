"""Measure what workflows/MEASURED.md states, and write it there, each row with its code's hash.

    python -m tests.measured                # rows older than their code, in small versions
    python -m tests.measured --full         # the same, in full versions, some of which take an hour
    python -m tests.measured presets kills  # these rows
    python -m tests.measured --older        # names the rows that are older than their code

A row whose command fails leaves the page. Exit code 1 of a campaign says that a promise is broken.
"""

import argparse
import json
import re
import shlex
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import date
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import psutil

from tests.sources.measure import ROOT, code_digest

PAGE = ROOT / "workflows" / "MEASURED.md"
HEADS = "| row | claim | figure | measured, code |\n|---|---|---|---|\n"


class Row(NamedTuple):
    """A claim, the rooms of the code that it speaks of, and the command that measures its figure.

    `full` has the arguments of the full version, None if the small one is it. `figure` makes the
    figure from what the command prints, and the CPU time that it took [s].
    """

    claim: str
    rooms: tuple[str, ...]
    command: str
    small: str
    full: str | None
    figure: object


def cells(text):
    """Rows of the Markdown tables in a text, as lists of cells, without headings."""
    lines = [*text.splitlines(), ""]
    rows = [line for line, below in pairwise(lines) if not below.startswith("|-")]
    return [row.strip("| ").split(" | ") for row in rows if row.startswith("| ")]


def presets(text, _):
    rows = {row[0]: row for row in cells(text)}
    bounds = {name: 100 * float(row[1]) for name, row in rows.items()}
    return "; ".join(
        f"`{name}` {row[5]} of {bounds[name]:.3g}%, {row[2]} positions"
        for name, row in rows.items()
    )


def stated(text, _):
    rows = [row for row in cells(text) if "," not in row[0] and len(row) == 8]
    return ", ".join(f"`{row[0]}` {row[7]} of {row[2]}" for row in rows)


def searches(text, _):
    rows = [row for row in cells(text) if len(row) == 7]
    *kinds, (_, _, at, between) = [row for row in cells(text) if len(row) == 4]
    points = {row[2]: [] for row in rows}
    for row in rows:
        if row[0] == rows[0][0]:
            points[row[2]].append(f"{row[3].split()[0]} ({row[1]})")
    counts = "; ".join(f"{accuracy}: {', '.join(texts)}" for accuracy, texts in points.items())
    lowest = min(kinds, key=lambda row: float(row[2].split()[0]))
    return (
        f"{at} of loads, {between} of positions between them; least {lowest[2]} ({lowest[0]}); "
        f"{counts}"
    )


def shares(text, _):
    inside, mild, severe = zip(*(row[2:] for row in cells(text)), strict=True)
    ends = [f"{min(map(_share, x))} to {max(map(_share, x))} %" for x in (inside, mild, severe)]
    return f"{ends[0]}; {ends[1]}; {ends[2]}"


def _share(text):
    return float(text.removesuffix(" %"))


def faults(name, prefix, words):
    """Figure of a campaign of ``tests.crash``: its faults, and how often it did what it does."""

    def figure(text, _):
        counts = json.loads(text)[name]
        number = sum(count for key, count in counts.items() if re.match(prefix, key))
        done = f", {counts['acknowledged']} finished points" if "acknowledged" in counts else ""
        return f"{counts['faults_in_all']} faults in {number} {words}{done}"

    return figure


def scan(text, _):
    counts = json.loads(text)
    scan_excess = {
        key: counts["scan"][key] - counts["sweep"][key] for key in ("driver_ms", "workers_ms")
    }
    wall = 1e3 * counts["scan"]["wall_s"] / counts["scan"]["done"]
    plain = counts["sweep"]["driver_ms"] - counts["empty"]["driver_ms"]
    return (
        f"{plain:.2g} ms of the driver; {counts['scan']['sent_mb']:.2g} MB sent; "
        f"{scan_excess['driver_ms']:.0f} ms of the driver, "
        f"{scan_excess['workers_ms']:.0f} ms of a worker; {wall:.0f} ms from point to point, "
        "two workers"
    )


def many(text, _):
    counts = json.loads(text)["large"]
    return (
        f"{counts['run']['computed']} points in {counts['files']} files; {counts['open'][0]} s to "
        f"open, {counts['resumed']['wall']} s to resume, {counts['verify'][0]} s to verify"
    )


def cpu(_, seconds):
    return f"{seconds:.0f} s of CPU time"


def last_line(text, _):
    return text.strip().splitlines()[-1]


def passed(text, _):
    return re.search(r"\d+ passed(, \d+ \w+)*", text)[0]


RUN, STORE = ("pipeline/run", "pipeline/store"), ("pipeline/store",)
ROWS = {
    "presets": Row(
        "99 % of errors of the critical velocity, without a warning, are below the bound of the "
        "preset, or 3.5 % if the pin wears under strips of the disk",
        ("tribo",),
        "python -m tests.promises.front",
        "--scenes 8 --minutes 3",
        "",
        presets,
    ),
    "moving disk": Row(
        "largest mean error of the rise, relative to loops of 384 positions of a moving disk, with "
        "and without a lay",
        ("tribo",),
        "python -m tests.promises.moving_disk",
        "--scenes 2",
        "",
        last_line,
    ),
    "stated": Row(
        "the stated errors hold, at points and between them",
        ("tribo", "pipeline/answers"),
        "python -m tests.promises.errors",
        "--scenes 3 --minutes 5",
        "",
        stated,
    ),
    "realizations": Row(
        "1 to 8 surface realizations agree with all others within their stated errors (95 %)",
        ("tribo", "pipeline/answers"),
        "python -m tests.promises.realizations",
        "",
        None,
        last_line,
    ),
    "loads": Row(
        "goals of 1 and 2 % hold on planes whose boundary is known; points of a search (loads)",
        ("pipeline/answers", "pipeline/run"),
        "python -m tests.promises.loads",
        "--planes 4",
        "",
        searches,
    ),
    "laboratories": Row(
        "synthetic laboratories: 90 % intervals that contain the bias; severe positions among "
        "those judged mild, at 2 to 5 %; mild ones among those judged severe, at 95 to 98 %",
        ("pipeline/answers",),
        "python -m tests.promises.laboratories",
        "100",
        "",
        shares,
    ),
    "past heat": Row(
        "excess of Θ₁₀ without the history of the heat, for `first_try` at 400 N and 1 m/s",
        ("tribo",),
        "python -m tests.promises.past_heat",
        "",
        None,
        last_line,
    ),
    "extremes": Row(
        "extreme velocities, loads, wear rates, durations, grids, surfaces and materials are "
        "solved, or refused with the reason",
        ("tribo",),
        "python -m pytest tests/tribo/simulation/test_extremes.py",
        "-q",
        None,
        passed,
    ),
    "diagram": Row(
        "computing time of a diagram of 228 points with fields, 480 × 480 pixels",
        ("tribo", *RUN),
        "irg run irg_transition",
        "-o results/measured.zarr",
        None,
        cpu,
    ),
    "scan": Row(
        "CPU time of the driver for a cheap point, beyond that of an empty task; additional cost "
        "of a scan of 1000 × 1000 heights (8 MB)",
        RUN,
        "python -m tests.cluster.cheap",
        "--points 2000 --scan 1000",
        "--points 10000 --scan 1000",
        scan,
    ),
    "many": Row(
        "times for many cheap points in one store",
        RUN,
        "python -m tests.crash.many",
        "--many 10000",
        "",
        many,
    ),
    "kills": Row(
        "the driver, workers, or all processes are killed",
        RUN,
        "python -m tests.crash kills",
        "--trials 2",
        "",
        faults("kills", "kills", "kills"),
    ),
    "power": Row(
        "the power of a mounted disk is cut",
        STORE,
        "python -m tests.crash power",
        "--trials 2",
        "",
        faults("power", "cuts", "cuts"),
    ),
    "damage": Row(
        "bits of files are flipped; files are cut, zeroed, deleted, or replaced by older ones",
        STORE,
        "python -m tests.crash damage",
        "--trials 20",
        "",
        faults("damage", "(?!seconds|faults|looks|ack|trials)", "files"),
    ),
    "pairs": Row(
        "a kill, then a full disk or a second driver, before the first fault is repaired",
        STORE,
        "python -m tests.crash pairs",
        "--trials 120",
        "",
        faults("pairs", "(?!seconds|faults)", "pairs"),
    ),
}


def rows_of(page):
    """Rows of the page by name: cells of each."""
    return {
        row[0]: row
        for line in page.splitlines()
        if (row := line.strip("| ").split(" | "))[0] in ROWS
    }


def is_old(row):
    """True if a row of the page is older than the code that it speaks of."""
    return row[-1].rpartition(", ")[2] != code_digest(*ROWS[row[0]].rooms)


def watched(process):
    """Output of a process, and CPU time of it and its descendants [s]; workers are no children."""
    with ThreadPoolExecutor(1) as reader:
        output, times = reader.submit(process.stdout.read), {}
        while not output.done():
            with suppress(psutil.NoSuchProcess):
                parent = psutil.Process(process.pid)
                for member in (parent, *parent.children(recursive=True)):
                    with suppress(psutil.NoSuchProcess):
                        times[member.pid] = sum(member.cpu_times()[:2])
            time.sleep(0.2)
        process.wait()
        return output.result(), sum(times.values())


def measured(name, is_full):
    """Run the command of a row; return the row of the page, None if the command fails."""
    row = ROWS[name]
    arguments = row.full if is_full and row.full is not None else row.small
    command = f"{row.command} {arguments}".strip()
    words = shlex.split(command)
    program = (
        [sys.executable] if words[0] == "python" else [str(Path(sys.executable).parent / "irg")]
    )
    shutil.rmtree(ROOT / "results" / "measured.zarr", ignore_errors=True)
    digest = code_digest(*row.rooms)
    with subprocess.Popen(
        [*program, *words[1:]], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as process:
        text, seconds = watched(process)
    if process.returncode not in (0, 1) or not text:
        print(f"{name}: {command} ended with {process.returncode}")
        return None
    figure = row.figure(text, seconds)
    broken = "**the promise is broken**" if is_full else "the promise fails on this sample"
    figure += f"; {broken}" * process.returncode
    print(f"{name}: {figure}", flush=True)
    return name, row.claim, figure, f"{date.today():%m-%d}, {digest}"


def main():
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.measured", description=__doc__)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--full", action="store_true", help="take full versions")
    parser.add_argument("--older", action="store_true", help="only name older rows")
    options = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    page_rows = rows_of(page)
    older = [name for name in ROWS if name not in page_rows or is_old(page_rows[name])]
    if options.older:
        print("\n".join(older) or "no row is older than its code")
        return 0
    for name in options.rows or older:
        page_rows.pop(name, None)
        if row := measured(name, options.full):
            page_rows[name] = row
        lines = ("| " + " | ".join(page_rows[key]) + " |\n" for key in ROWS if key in page_rows)
        PAGE.write_text(page.partition(HEADS)[0] + HEADS + "".join(lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
