"""Judge the intervals of `pipeline.posterior`, and what a plan promises, by hidden truths.

A batch of tests is planned once for the critical temperature, and made on each of many truths by
direct simulations. Velocities scatter as said, or by a factor of that drawn as the tool assumes it.
If all is right, the rank of each hidden value among the draws is uniform, z (the distance of the
mean over the standard deviation) is 1 root mean square, and 90 % intervals hold 90 %.

A line for each truth is added to the file, and the next run goes on from there. Prints a JSON
document; the exit code is 1 unless intervals of 90 % hold 85 to 95 %, z is 0.9 to 1.1, and ranks
are uniform by a Kolmogorov–Smirnov test at 0.1 % where scatters are drawn, 85 % are held and z is
1.1 at most where they are as said, and the spread promised is 0.8 to 1.25 of that had, within its
standard error; with ``--promise`` it is that of the spread alone.
"""

import argparse
import json
import math
import sys
import time
from pathlib import Path

import numpy as np
from scipy import stats

import pipeline
from pipeline.uncertain.evidence import FACTOR
from pipeline.uncertain.inputs import CRITICAL
from tests.helpers.campaigns import conclude
from tests.promises.rigs import BULKS, SCATTER, add_rig_options, idle, rigs_of, weighed

LAWS = ("as said", "drawn")


def logged(rig, batch, law):
    """Tests of a batch, as a log of the rig has them."""
    share = van_der_corput(rig.seed + 1)  # so that few rigs have scatters as many would
    factor = FACTOR ** float(stats.norm.ppf(share)) if law == "drawn" else 1.0
    for planned in batch:
        place = planned.test["normal_load"], planned.test["bulk_temperature"]
        if "transition" in planned.what:
            yield rig.searched(*place, SCATTER * factor)
        else:
            yield rig.tried(place[0], planned.test["velocity"], place[1], SCATTER * factor)


def van_der_corput(number):
    """Element of the sequence that fills 0 to 1 evenly, however many are taken."""
    digits = f"{number:b}"[::-1]
    return int(digits, 2) / 2 ** len(digits)


def judged(posterior, truth):
    """Mean, spread, rank and interval of each input beside its hidden value."""
    draws = posterior.draws
    # The inputs of the rig, which stand last, are none of the truth's.
    for unknown, column, hidden in zip(posterior.unknown, draws.inputs.T, truth, strict=False):
        if unknown.kind == "list":
            continue
        values, value = (np.log(v) if unknown.is_relative else v for v in (column, hidden))
        mean = float(draws.mean(values))
        yield (
            unknown.path,
            {
                "error": float(value) - mean,
                "spread": math.sqrt(float(draws.mean((values - mean) ** 2))),
                "rank": float(draws.mean(values < value)),
                "held": bool(draws.quantile(values, 0.05) <= value <= draws.quantile(values, 0.95)),
            },
        )


def reported(rows, promised):
    """Summary of ranks, z and intervals by law and input."""
    for law in LAWS:
        of_law = [row["inputs"] for row in rows if row["law"] == law]
        result = {"truths": len(of_law)}
        for path in of_law[0] if of_law else ():
            error, spread, rank, held = (
                np.array([row[path][name] for row in of_law], float)
                for name in ("error", "spread", "rank", "held")
            )
            in_tenths = np.histogram(rank, 10, (0.0, 1.0))[0]
            result[path] = {
                "held": float(held.mean()),
                "z_rms": float(np.sqrt(np.mean((error / spread) ** 2))),
                "z_mean": float(np.mean(error / spread)),
                "ranks_ks_p": float(stats.kstest(rank, "uniform").pvalue),
                "ranks_chi_square_p": float(stats.chisquare(in_tenths).pvalue),
                "spread": float(np.sqrt(np.mean(spread**2))),
                "error": float(np.sqrt(np.mean(error**2))),
            }
        if of_law:
            squares = np.array([row[CRITICAL]["spread"] for row in of_law]) ** 2
            ratio = result[CRITICAL]["spread"] / promised
            again = np.random.default_rng(0).choice(squares, (2000, len(squares)))
            result["spread_over_promise"] = ratio
            result["its_error"] = float(np.std(np.sqrt(again.mean(axis=1)))) / promised
        yield law, result


def is_right(law, result):
    """True if the critical temperature's intervals and spread are as they ought to be.

    Scatters as said are the middle of those that the tool assumes: so the intervals of such truths
    may be wider than need be, but no narrower.
    """
    critical = result[CRITICAL]
    is_wide_enough = critical["held"] >= 0.85 and critical["z_rms"] <= 1.1
    if law == "as said":
        return is_wide_enough
    is_narrow_enough = critical["held"] <= 0.95 and critical["z_rms"] >= 0.9
    return is_wide_enough and is_narrow_enough and critical["ranks_ks_p"] >= 1e-3


def is_as_promised(result):
    """True if the promised spread is 0.8 to 1.25 of that had, as far as so many truths tell.

    A few truths of a large spread decide the root mean square: of 12 rigs it is 0.6 to 1.4 of that
    of many.
    """
    ratio, error = result["spread_over_promise"], result["its_error"]
    return 1 / max(ratio - error, 1e-9) >= 0.8 and 1 / (ratio + error) <= 1.25


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.coverage", description=__doc__)
    add_rig_options(parser)
    parser.add_argument("--truths", type=int, default=250)
    parser.add_argument("--tests", type=int, nargs="+", default=[4], help="of a batch, ascending")
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=LAWS, help="of the scatter")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no truth later")
    parser.add_argument("--promise", action="store_true", help="judge the promised spread alone")
    parser.add_argument("--file", type=Path, help="results/coverage_CASE_TESTS.jsonl")
    options = parser.parse_args()
    counts = "_".join(map(str, options.tests))
    path = options.file or Path(f"results/coverage_{options.case}_{counts}.jsonl")
    path.parent.mkdir(parents=True, exist_ok=True)
    ensemble, rig_of = rigs_of(options)
    before = weighed(ensemble, [idle(ensemble)])
    batch = pipeline.plan_tests(before, options.tests[-1], CRITICAL, BULKS[options.case])
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    began = time.monotonic()
    for number in range(len({row["truth"] for row in rows}), options.truths):
        if time.monotonic() - began > 60 * options.minutes:
            break
        started, rig = time.process_time(), rig_of(number)
        new = []
        for law in options.laws:
            tests = [*logged(rig, batch, law)]
            for count in options.tests:
                posterior = weighed(ensemble, tests[:count], fewer=4 if options.promise else 1)
                inputs = dict(judged(posterior, rig.truth))
                new.append({"truth": number, "law": law, "tests": count, "inputs": inputs})
        new[-1]["seconds"] = time.process_time() - started
        rows += new
        with path.open("a") as file:
            file.writelines(json.dumps(row) + "\n" for row in new)
    results, held = {}, bool(rows)
    for count in options.tests if rows else ():
        promised = batch[count - 1].spread
        of_count = [row for row in rows if row["tests"] == count]
        by_law = {law: one for law, one in reported(of_count, promised) if one["truths"]}
        held &= options.promise or all(is_right(*item) for item in by_law.items())
        held &= all(map(is_as_promised, by_law.values()))
        results[f"{count} tests"] = {"promised": promised} | by_law
    plan = {"batch": [one.what for one in batch]}
    return conclude(path.stem, json.dumps(plan | results, indent=1), held)


if __name__ == "__main__":
    sys.exit(main())
