"""Judge what samples with tests say of a further laboratory run, by hidden truths.

Each truth is a rig whose runs scatter by as much as the tool assumes beforehand, or by a fixed
share. Its tests are direct simulations. At each load the velocity is sought at which a further run
is said to be severe with 1, 5 and 20 %; the true probability there follows from the rig's own
transition, found by direct simulations, and its own scatter. No run is counted.

A line for each truth is added to the file, and the next run goes on from there. Prints a JSON
document; the exit code is 1 if true probabilities are too far from what is said.
"""

import argparse
import json
import math
import sys
import time
from pathlib import Path

import numpy as np
from scipy import stats

from pipeline.uncertain.answers import draws_of
from pipeline.uncertain.evidence import FACTOR
from pipeline.uncertain.fields import SampleField
from tests.helpers.campaigns import conclude
from tests.promises.coverage import van_der_corput
from tests.promises.rigs import BULKS, SCATTER, add_rig_options, rigs_of, weighed

SAID = (0.01, 0.05, 0.2)
FIXED = (0.05, 0.1, 0.2)
"""Relative standard deviations of the velocity of a run."""
_MOST = {8: 2.6, 24: 1.6}
_FACTOR = 1.3
_GRID = 241


def law_scatters(seed):
    """Scatter of a rig's runs by law: drawn from the assumed prior, or fixed."""
    drawn = SCATTER * FACTOR ** float(stats.norm.ppf(van_der_corput(seed + 1)))
    return {"drawn": drawn} | {f"{100 * one:g} %": one for one in FIXED}


def next_run(ensemble, posterior):
    """Field of samples weighed by tests, which predicts a further laboratory run."""
    return SampleField(ensemble, draws_of(ensemble, posterior.draws), None, posterior)


def true_probabilities(field, rig, load, bulk, scatter):
    """True probabilities that a further run is severe where the predicted ones are `SAID`.

    None if such a velocity, or the transition, is outside the sweep.
    """
    transition = rig.transition(load, bulk)
    if not math.isfinite(transition):
        return None
    velocities = np.geomspace(*field.ensemble.velocities, _GRID)
    said = np.maximum.accumulate(field.probability(load, velocities, field.scatter))
    if not said[0] < SAID[0] or not said[-1] > SAID[-1]:
        return None
    places = np.interp(SAID, said, np.log(velocities))
    return stats.norm.cdf((places - transition) / scatter).tolist()


def judged(ensemble, rig, scatter, count, bulk):
    """True probabilities of a rig by load, after `count` measured transitions."""
    loads = np.resize(ensemble.loads, count).tolist()
    posterior = weighed(ensemble, [rig.searched(load, bulk, scatter) for load in loads])
    field = next_run(posterior.ensemble, posterior)
    found = (true_probabilities(field, rig, float(load), bulk, scatter) for load in ensemble.loads)
    return [one for one in found if one]


def reported(rows):
    """Yield mean true/predicted probability and its standard error, by law and prediction."""
    for law in dict.fromkeys(row["law"] for row in rows):
        means = [np.mean(row["true"], axis=0) for row in rows if row["law"] == law and row["true"]]
        ratios = np.array(means) / SAID
        errors = ratios.std(axis=0, ddof=1) / math.sqrt(len(ratios))
        yield (
            law,
            {
                f"{100 * said:g} %": {"ratio": ratio, "error": error}
                for said, ratio, error in zip(SAID, ratios.mean(axis=0), errors, strict=True)
            }
            | {"truths": len(ratios)},
        )


def comes_true(law, result, count):
    """True if true/predicted probabilities are within the bounds, allowing one standard error."""
    for said in (f"{100 * one:g} %" for one in SAID):
        ratio, error = result[said]["ratio"], result[said]["error"]
        most = _FACTOR if law == "drawn" else _MOST[count]
        if ratio - error > most or (law == "drawn" and ratio + error < 1 / _FACTOR):
            return False
    return True


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.runs", description=__doc__)
    add_rig_options(parser)
    parser.add_argument("--truths", type=int, default=300)
    parser.add_argument("--tests", type=int, choices=_MOST, default=8)
    laws = tuple(law_scatters(0))
    parser.add_argument("--laws", nargs="+", choices=laws, default=laws, help="of the scatter")
    parser.add_argument("--minutes", type=float, default=120.0, help="begin no truth later")
    parser.add_argument("--file", type=Path, help="results/runs_TESTS.jsonl")
    options = parser.parse_args()
    path = options.file or Path(f"results/runs_{options.tests}.jsonl")
    path.parent.mkdir(parents=True, exist_ok=True)
    ensemble, rig_of = rigs_of(options)
    bulk = BULKS[options.case][0]
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    began = time.monotonic()
    for number in range(len({row["truth"] for row in rows}), options.truths):
        if time.monotonic() - began > 60 * options.minutes:
            break
        rig, scatters, new = rig_of(number), law_scatters(number), []
        for law in options.laws:
            scatter = scatters[law]
            true = judged(ensemble, rig, scatter, options.tests, bulk)
            new.append({"truth": number, "law": law, "scatter": scatter, "true": true})
        rows += new
        with path.open("a") as file:
            file.writelines(json.dumps(row) + "\n" for row in new)
    results = dict(reported(rows))
    held = bool(results) and all(comes_true(*item, options.tests) for item in results.items())
    return conclude(path.stem, json.dumps(results, indent=1), held)


if __name__ == "__main__":
    sys.exit(main())
