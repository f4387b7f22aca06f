"""Measure what workflows/MEASURED.md states, and write the page.

    python -m tests.measured                # rows older than their code, in small versions
    python -m tests.measured --full         # the same, in full versions, some of which take an hour
    python -m tests.measured presets kills  # these rows
    python -m tests.measured --older        # names the rows that are older than their code
    python -m tests.measured --page         # measures nothing, and writes the page

Figures, dates and hashes are kept in ``tests/promises/measured.json``. A row whose command fails
leaves the page. Exit code 1 of a campaign says that a promise is broken.
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
FIGURES = ROOT / "tests" / "promises" / "measured.json"
HEADS = "| claim | measured | to repeat: `python -m tests.measured` |\n|---|---|---|\n"


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
        "At 99 % of positions without a warning, the critical velocity errs by less than the bound "
        "of the preset; for a pin that wears under strips of the disk, with the stated error by "
        "their positions",
        ("tribo",),
        "python -m tests.promises.front",
        "--scenes 8 --minutes 3",
        "",
        presets,
    ),
    "positions": Row(
        "At 95 % of positions of the disk's strips, the rise deviates from its mean by less than "
        "the stated error; judged on scenes that did not set it",
        ("tribo",),
        "python -m tests.promises.positions",
        "--scenes 4",
        "",
        last_line,
    ),
    "moving disk": Row(
        "The mean temperature rise is that under a disk that moves through 384 positions, with and "
        "without a lay; largest mean deviation, a bias that no stated error contains",
        ("tribo",),
        "python -m tests.promises.moving_disk",
        "--scenes 2",
        "",
        last_line,
    ),
    "stated": Row(
        "95 % of errors are below the stated bound, at simulated points and between them",
        ("tribo", "pipeline/answers"),
        "python -m tests.promises.errors",
        "--scenes 3 --minutes 5",
        "",
        stated,
    ),
    "realizations": Row(
        "The mean of 1 to 8 surface realizations is that of all others within its 95 % bound",
        ("tribo", "pipeline/answers"),
        "python -m tests.promises.realizations",
        "",
        None,
        last_line,
    ),
    "loads": Row(
        "Accuracy goals of 1 and 2 % hold on planes whose boundary is known in closed form; points "
        "that a search needs (loads)",
        ("pipeline/answers", "pipeline/run"),
        "python -m tests.promises.loads",
        "--planes 4",
        "",
        searches,
    ),
    "laboratories": Row(
        "Of synthetic laboratories: 90 % intervals of the model bias that contain it; severe "
        "specimens among those judged mild with 2 to 5 %; mild ones among those judged severe with "
        "95 to 98 %",
        ("pipeline/answers",),
        "python -m tests.promises.laboratories",
        "100",
        "",
        shares,
    ),
    "inputs": Row(
        "With all inputs uncertain by up to 20 %, the linear rule and simulations of the same 200 "
        "draws agree within 5 % of the standard deviation of ln(rise), and within 0.02 of the "
        "probability P of severe wear, beyond two standard errors",
        ("tribo", "pipeline/answers", "pipeline/scene"),
        "python -m tests.promises.inputs",
        "--draws 30 --points 1 --sizes 0.2 --file results/inputs-small.jsonl",
        "",
        last_line,
    ),
    "past heat": Row(
        "Leaving out the history of the heat makes Θ₁₀ too high: `first_try` at 400 N and 1 m/s",
        ("tribo",),
        "python -m tests.promises.past_heat",
        "",
        None,
        last_line,
    ),
    "extremes": Row(
        "Extreme velocities, loads, wear rates, durations, grids, surfaces and materials are "
        "solved, or refused with the reason",
        ("tribo",),
        "python -m pytest tests/tribo/simulation/test_extremes.py",
        "-q",
        None,
        passed,
    ),
    "diagram": Row(
        "A diagram of 228 points with fields, 480 × 480 pixels, takes seconds",
        ("tribo", *RUN),
        "irg run irg_transition",
        "-o results/measured.zarr",
        None,
        cpu,
    ),
    "scan": Row(
        "A cheap point costs the driver little CPU time beyond that of an empty task; a scan of "
        "1000 × 1000 heights (8 MB) adds more",
        RUN,
        "python -m tests.cluster.cheap",
        "--points 2000 --scan 1000",
        "--points 10000 --scan 1000",
        scan,
    ),
    "many": Row(
        "A store of many cheap points is opened, resumed and verified in seconds",
        RUN,
        "python -m tests.crash.many",
        "--many 10000",
        "",
        many,
    ),
    "kills": Row(
        "No finished point is lost or changed when the driver, workers or all processes are killed",
        RUN,
        "python -m tests.crash kills",
        "--trials 2",
        "",
        faults("kills", "kills", "kills"),
    ),
    "power": Row(
        "No finished point is lost or changed when the power of a mounted disk is cut",
        STORE,
        "python -m tests.crash power",
        "--trials 2",
        "",
        faults("power", "cuts", "cuts"),
    ),
    "damage": Row(
        "No damaged data are taken for sound, and no damaged document costs a store: flipped bits; "
        "files cut, zeroed, deleted, replaced by older ones",
        STORE,
        "python -m tests.crash damage",
        "--trials 20",
        "",
        faults("damage", "(?!seconds|faults|looks|ack|trials)", "files"),
    ),
    "pairs": Row(
        "No finished point is lost or changed by a kill and then a full disk or a second driver, "
        "before the first fault is repaired",
        STORE,
        "python -m tests.crash pairs",
        "--trials 120",
        "",
        faults("pairs", "(?!seconds|faults)", "pairs"),
    ),
}


def figures():
    """Measured figures by name: text, date, and hash of the code."""
    return json.loads(FIGURES.read_text(encoding="utf-8"))


def page_of(text, measured_figures):
    """Text of the page with a row for each measured figure."""
    lines = (
        f"| {row.claim} | {measured_figures[name]['figure']} | `{name}` |\n"
        for name, row in ROWS.items()
        if name in measured_figures
    )
    return text.partition(HEADS)[0] + HEADS + "".join(lines)


def is_old(name, figure):
    """True if a figure is older than the code that it speaks of."""
    return figure["code"] != code_digest(*ROWS[name].rooms)


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
    """Run the command of a row; return its figure, None if the command fails."""
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
    if process.returncode:
        figure += "; **the claim does not hold**" if is_full else "; not met by this small sample"
    print(f"{name}: {figure}", flush=True)
    return {"figure": figure, "date": f"{date.today():%m-%d}", "code": digest}


def main():
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.measured", description=__doc__)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--full", action="store_true", help="take full versions")
    parser.add_argument("--older", action="store_true", help="only name older rows")
    parser.add_argument("--page", action="store_true", help="only write the page")
    options = parser.parse_args()
    known = figures()
    older = [name for name in ROWS if name not in known or is_old(name, known[name])]
    if options.older:
        print("\n".join(older) or "no row is older than its code")
        return 0
    for name in () if options.page else options.rows or older:
        known.pop(name, None)
        if figure := measured(name, options.full):
            known[name] = figure
        text = json.dumps(known, indent=1, ensure_ascii=False)
        FIGURES.write_text(f"{text}\n", encoding="utf-8")
    PAGE.write_text(page_of(PAGE.read_text(encoding="utf-8"), known), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
