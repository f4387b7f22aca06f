"""Judge the intervals of `pipeline.posterior` by hidden truths.

The same tests are made on each of many truths by direct simulations: at each load and bulk
temperature in turn, at the velocity where the transition is as likely above as below. Velocities
scatter as said, or by a factor drawn as the tool assumes it. If all is right, ranks among draws are
uniform, z (error of the mean over the standard deviation) is 1 rms, and intervals hold 90 %.

A line for each truth is added to the file, and the next run goes on from there. Prints a JSON
document; the exit code is 1 if shares, z or ranks (Kolmogorov–Smirnov) miss their bounds.
"""

import argparse
import itertools
import json
import math
import sys
import time
from pathlib import Path

import numpy as np
from scipy import stats

from pipeline.uncertain.evidence import FACTOR
from pipeline.uncertain.inputs import CRITICAL, prior
from tests.helpers.campaigns import conclude
from tests.promises.rigs import (
    BULKS,
    SCATTER,
    add_rig_options,
    log_transitions,
    rigs_of,
    weighed,
)

LAWS = ("as said", "drawn")


def places(ensemble, bulks, count):
    """Yield load, velocity and bulk temperature of tests whose outcome is uncertain beforehand."""
    inputs = prior(ensemble.unknown, ensemble.design.seed, 2**10).inputs
    at = itertools.cycle(itertools.product(ensemble.loads.tolist(), bulks))
    for load, bulk in itertools.islice(at, count):
        middle = math.exp(np.median(log_transitions(ensemble, inputs, load, bulk)))
        yield load, float(np.clip(middle, *ensemble.velocities)), bulk


def logged(rig, at, law):
    """Tests of a rig at these places, as entries of a log."""
    share = van_der_corput(rig.seed + 1)  # evenly spread scatters, even for few rigs
    factor = FACTOR ** float(stats.norm.ppf(share)) if law == "drawn" else 1.0
    return [rig.tried(*place, SCATTER * factor) for place in at]


def van_der_corput(number):
    """Element `number` of the van der Corput sequence, which fills 0 to 1 evenly."""
    digits = f"{number:b}"[::-1]
    return int(digits, 2) / 2 ** len(digits)


def judged(posterior, truth):
    """Yield, by input, how its posterior compares with the hidden true value."""
    draws = posterior.draws
    # The rig's own inputs come last, and have no hidden true value.
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


def reported(rows):
    """Yield statistics of ranks, z scores and intervals of each input, by law of the scatter."""
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
        yield law, result


def is_right(law, result):
    """True if 90 % intervals of the critical temperature hold the truth as often as they should.

    With the stated scatter, which is the middle of what inference assumes, they may be wider than
    needed, but no narrower.
    """
    critical = result[CRITICAL]
    is_wide_enough = critical["held"] >= 0.85 and critical["z_rms"] <= 1.1
    if law == "as said":
        return is_wide_enough
    is_narrow_enough = critical["held"] <= 0.95 and critical["z_rms"] >= 0.9
    return is_wide_enough and is_narrow_enough and critical["ranks_ks_p"] >= 1e-3


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.coverage", description=__doc__)
    add_rig_options(parser)
    parser.add_argument("--truths", type=int, default=250)
    parser.add_argument("--tests", type=int, default=4, help="of each truth")
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=LAWS, help="of the scatter")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no truth later")
    parser.add_argument("--file", type=Path, help="results/coverage_CASE_TESTS.jsonl")
    options = parser.parse_args()
    path = options.file or Path(f"results/coverage_{options.case}_{options.tests}.jsonl")
    path.parent.mkdir(parents=True, exist_ok=True)
    ensemble, rig_of = rigs_of(options)
    at = [*places(ensemble, BULKS[options.case], options.tests)]
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    began = time.monotonic()
    for number in range(len({row["truth"] for row in rows}), options.truths):
        if time.monotonic() - began > 60 * options.minutes:
            break
        started, rig = time.process_time(), rig_of(number)
        new = []
        for law in options.laws:
            inputs = dict(judged(weighed(ensemble, logged(rig, at, law)), rig.truth))
            new.append({"truth": number, "law": law, "inputs": inputs})
        new[-1]["seconds"] = time.process_time() - started
        rows += new
        with path.open("a") as file:
            file.writelines(json.dumps(row) + "\n" for row in new)
    results = {law: one for law, one in reported(rows) if one["truths"]}
    held = bool(results) and all(is_right(*item) for item in results.items())
    return conclude(path.stem, json.dumps(results, indent=1), held)


if __name__ == "__main__":
    sys.exit(main())
