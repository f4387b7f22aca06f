"""Report of a campaign: number of scenes on which `--accuracy` kept its promise."""

import numpy as np

from tests.helpers.campaigns import conclude, table

ACCURACIES = (0.05, 0.02, 0.01)
COLUMNS = ("promise", "scenes", "kept", "broken in silence", "median", "90 % below", "largest")
LEAST = {"cylinders": 0.96, "wide": 0.9}
"""Share of scenes that keep a promise at all places, of which 99 % keep it: cylinders have four."""
SILENT = 0.02
"""Share of scenes that may break it without a warning, or beyond the stated error."""

DEARER = 1.5
"""Time of the row that `--accuracy` picks, at most, over that of the fastest within the bound.

Rows are ordered by their work; times of these short probes vary by up to a third on a busy machine.
"""


def kept(name, bound, errors, excuses):
    """Table row of a promise: numbers of scenes, kept, broken without an excuse, and errors."""
    errors, excused = np.array(errors), np.array([bool(one) for one in excuses])
    silent = np.sum((errors > bound) & ~excused)
    shown = (f"{size:.2%}" for size in (*np.quantile(errors, [0.5, 0.9]), errors.max()))
    return f"{name}: {100 * bound:g}%", len(errors), np.sum(errors <= bound), silent, *shown


def are_right(rows, family):
    """True if enough scenes keep each promise, and few break it in silence."""
    return bool(rows) and all(
        scenes - held <= max((1 - LEAST[family]) * scenes, 1) and silent <= max(SILENT * scenes, 1)
        for _, scenes, held, silent, *_ in rows
    )


def report(rows_by_seed, family):
    """Print the number of kept promises, from the results of each scene; return the exit code."""
    parts = [row for parts in rows_by_seed.values() for row in parts.values()]
    failed = {row["seed"]: row["failed"] for row in parts if "failed" in row}
    judged = [row for row in parts if row["part"] == "accuracies" and "failed" not in row]
    rows, notes = [], [f"- scene {seed}: {why}" for seed, why in failed.items()]
    for accuracy in ACCURACIES if judged else ():
        found = [row[f"{accuracy:g}"] for row in judged]
        said = [one["error"] <= one["stated"] for one in found]
        shares = [one["error"] / one["stated"] for one in found]
        dearer, excuses = _columns(found, "dearer", "warnings")
        words = f"{accuracy:.0%}"
        rows.append(kept("--accuracy", accuracy, [one["error"] for one in found], said))
        rows.append(kept(f"share of the error that {words} states", 1.0, shares, excuses))
        rows.append(kept(f"time over that of the fastest within {words}", DEARER, dearer, found))
        notes += [
            f"- {accuracy:.0%}: scene {row['seed']} errs by {one['error']:.2%}, stated "
            f"{one['stated']:.2%} ({one['name']}; {', '.join(one['warnings']) or 'no warning'})"
            for row, one in zip(judged, found, strict=True)
            if one["error"] > max(accuracy, one["stated"])
        ]
    is_right = are_right(rows, family) and len(failed) <= SILENT * len(rows_by_seed)
    return conclude(f"promises_{family}", "\n".join([table(COLUMNS, rows), "", *notes]), is_right)


def _columns(rows, *names):
    return [[row[name] for row in rows] for name in names]
