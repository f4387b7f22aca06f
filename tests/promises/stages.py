"""Judge what runs by stages say of the boundary, by hidden truths.

Each truth has a scatter of its specimens. Each run has one velocity and one specimen, whose load
grows by stages until wear turns severe; the log has all stages. Asked is the critical velocity at a
load in the middle: how often its interval of 90 % holds the truth, and by how much the median is
off on average. The rise is known in closed form, or with ``--direct`` that of simulations.

Prints a JSON document; the exit code is 1 if a kind of stages misses its bounds.
"""

import argparse
import json
import math
import sys
from dataclasses import replace
from unittest import mock

import numpy as np
from scipy.interpolate import CubicSpline

import pipeline
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.unknown import drawn
from tests.helpers.campaigns import conclude
from tests.helpers.samples import critical_velocity
from tests.helpers.unknowns import CRITICAL, FRICTION, LENGTH, RATE
from tests.promises.laboratories import closed_excess, samples_of
from tests.promises.rigs import add_rig_options, rigs_of, weighed

KINDS = {"5 %": (0.05, 0.10), "10 %": (0.10, 0.15), "25 %": (0.25, 0.10)}
"""Step of the load, and scatter of the specimens in velocity."""
HELD, OFF = (0.85, 0.95), 0.02
WIDE = 20.0  # prior standard deviation of the critical temperature [K]
_SEED = 2718
_WITHIN = 0.8  # share of the range of ln(load) in which runs turn severe


def staged(load_transition, ends, step, scatter, count, chance):
    """Yield the tests of `count` stepwise runs; `load_transition` maps ln(load) to ln(velocity).

    Their velocities are such that wear turns severe at loads of the sweep.
    """
    low, high = np.log(ends)
    loads = np.exp(np.arange(low, high, math.log1p(step)))
    middle, half = (low + high) / 2, _WITHIN * (high - low) / 2
    for run in range(count):
        aim = middle + half * (2 * (run + 0.5) / count - 1)
        velocity = math.exp(float(load_transition(aim)))
        off = scatter * chance.standard_normal()
        for load in loads.tolist():
            is_severe = math.log(velocity) + off > float(load_transition(math.log(load)))
            outcome = "severe" if is_severe else "mild"
            place = {"normal_load": load, "velocity": velocity, "run": str(run)}
            yield place | {"outcome": outcome}
            if is_severe:
                break


def transition_line(loads, places):
    """Spline of ln(critical velocity) over ln(load); None if a transition is outside the sweep."""
    return CubicSpline(np.log(loads), places) if np.isfinite(places).all() else None


def judge(ensemble, truth, step, scatter, count, chance, weigh):
    """Error of the inferred critical velocity at a middle load; if its interval holds the truth."""
    tests = staged(truth, ensemble.loads[[0, -1]], step, scatter, count, chance)
    posterior = weigh(ensemble, list(tests))
    load = math.exp(np.log(ensemble.loads[[0, -1]]).mean())
    draws = posterior.draws
    found = log_boundary(ensemble, draws.inputs[:, : len(ensemble.unknown)], [load])[0][:, 0]
    low, middle, high = draws.interval(found)
    actual = float(truth(math.log(load)))
    return {"off": middle - actual, "held": bool(low <= actual <= high), "width": high - low}


def summarise(rows):
    """Share of intervals that hold the truth, and mean error, with their standard errors."""
    off, held = (np.array([row[name] for row in rows], float) for name in ("off", "held"))
    n = len(rows)
    return {
        "truths": n,
        "held": float(held.mean()),
        "its_error": math.sqrt(0.9 * 0.1 / n),
        "off": float(off.mean()),
        "off_error": float(off.std(ddof=1)) / math.sqrt(n),
        "width": float(np.mean([row["width"] for row in rows])),
    }


def is_right(result, errors=1.0):
    """True if intervals hold as often as stated, and errors are small, within standard errors."""
    low, high = HELD
    spare = errors * result["its_error"]
    is_held = low - spare <= result["held"] <= high + spare
    return is_held and abs(result["off"]) - errors * result["off_error"] <= OFF


def closed_rigs(count):
    """Yield the ensemble, by a closed form, and the transition line of each of `count` truths."""
    inputs = (replace(CRITICAL, parameters=(CRITICAL.parameters[0], WIDE)), RATE, FRICTION, LENGTH)
    samples = samples_of(inputs)
    for truth in drawn(inputs, _SEED, count):
        places = [math.log(critical_velocity(truth[None], load)[0]) for load in samples.loads]
        yield samples, transition_line(samples.loads, places)


def direct_rigs(options):
    """Yield the ensemble of a scene, and the simulated transition line of each hidden truth."""
    ensemble, rig_of = rigs_of(options)
    bulk = ensemble.conditions.bulk_temperature
    for rig in map(rig_of, range(options.truths)):
        places = [rig.transition(float(load), bulk) for load in ensemble.loads]
        yield ensemble, transition_line(ensemble.loads, places)


def closed_form():
    """Context that replaces the emulator by the closed form."""
    return mock.patch.object(Ensemble, "excess", closed_excess)


def weigh_closed(ensemble, tests):
    """Posterior given tests, for an ensemble of the closed form."""
    return pipeline.posterior(replace(ensemble, tests=tuple(tests)))


def judged_rows(rigs, count, weigh):
    """Results of `judge` by kind of stages, for rigs with `count` runs each."""
    rows = {kind: [] for kind in KINDS}
    for number, (ensemble, truth) in enumerate(rigs):
        chance = np.random.default_rng((_SEED, number))
        for kind, (step, scatter) in KINDS.items() if truth else ():
            rows[kind].append(judge(ensemble, truth, step, scatter, count, chance, weigh))
        print(number, *(row[-1:] for row in rows.values()), file=sys.stderr, flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.stages", description=__doc__)
    parser.add_argument("--direct", action="store_true", help="by simulations of a scene")
    add_rig_options(parser)
    parser.add_argument("--truths", type=int, default=200)
    parser.add_argument("--runs", type=int, default=8, help="of each truth")
    options = parser.parse_args()
    if options.direct:
        rows = judged_rows(direct_rigs(options), options.runs, weighed)
    else:
        with closed_form():
            rows = judged_rows(closed_rigs(options.truths), options.runs, weigh_closed)
    results = {kind: summarise(of_kind) for kind, of_kind in rows.items()}
    right = all(map(is_right, results.values()))
    return conclude("stages", json.dumps(results, indent=1), right)


if __name__ == "__main__":
    sys.exit(main())
