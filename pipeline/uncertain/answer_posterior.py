"""The posterior of the unknown inputs, for ``irg infer``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pandas as pd

import pipeline
from pipeline.analysis.tables import frame_of, short
from pipeline.cli.given import conditions_in, values_in
from pipeline.cli.output import Result, working, wrapped
from pipeline.quantities import display
from pipeline.sweep.remarks import remarks
from pipeline.uncertain.inputs import CRITICAL, QUANTILES
from pipeline.uncertain.posterior import Contrast, Judged, Posterior, contrasts
from pipeline.uncertain.weigh import FALSE_ALARMS


def posterior(options: argparse.Namespace, store: Path) -> Result:
    """Answer ``irg infer`` for a store of samples: infer the unknown inputs from the tests.

    The result has text and a table of the inputs' distributions before and after the tests, and a
    figure. `options` are those of the command line.
    """
    with working("reading samples"):
        ds = pipeline.open_sweep(store)
        ensemble = pipeline.Ensemble.of(
            pipeline.at(ds, **conditions_in(options), **dict(options.at))
        )
    with working("weighing the inputs by the tests"):
        weighed = pipeline.posterior(ensemble, **values_in(options, "scatter"))
    document, text = weighed.as_dict(), wrapped(_describe_inputs(weighed))
    with working("comparing the oils"):
        compared = list(contrasts(weighed))
    document["differences"] = [one._asdict() for one in compared]
    text += wrapped(map(_describe_contrast, compared))
    draw = partial(pipeline.plot, weighed)
    return Result(document, text, pipeline.warned(ds), [_summary_frame(weighed)], draw)


def _describe_inputs(weighed: Posterior) -> Iterator[str | pd.DataFrame]:
    """Yield lines and tables on each input, before and after the tests, and on each test."""
    samples = len(weighed.ensemble.inputs)
    yield f"{weighed.evidence}, {weighed.scatter_words}; {samples} samples"
    yield from (f"  {one}" for one in weighed.ensemble.fixed)
    yield weighed.draws_words
    yield frame_of(("input", "before", "after", "90 % within"), weighed.in_words())
    for a, b, correlation in weighed.hidden():
        signed = f"{correlation:+.2f}".replace("-", "−")
        yield f"{a} and {b} cannot be told apart by these tests (correlation {signed})"
    if weighed.judged:
        yield "each test, beside the critical velocity by all tests together:"
        yield short(_test_quantiles(weighed))
    if weighed.fits and weighed.judged and any(CRITICAL in one.path for one in weighed.unknown):
        yield (
            "the model fits; it fits as well if all velocities are read too high, and the oil then "
            "looks better than it is: check the speed, or test a reference oil"
        )
    if not weighed.fits:
        yield from remarks("warning", f"{weighed.draws.misfit}; no single test can be blamed")
    contradicting = (
        f"{_describe_test(weighed, judged)}: by the other tests its probability is "
        f"{judged.probability:.1g}; only one sound log in {1 / FALSE_ALARMS:.0f} has a test below "
        f"{judged.limit:.1g}; look at the test, or leave it out"
        for judged in weighed.judged
        if judged.contradicts
    )
    yield from remarks("warning", *contradicting)


def _test_quantiles(weighed: Posterior) -> pd.DataFrame:
    """Frame with a row for each run of tests: 5, 50 and 95 % quantiles of the critical velocity."""
    ends = (f"critical velocity, {100 * share:g} % quantile [m/s]" for share in QUANTILES)
    heads = "test", "oil", "load [N]", "bulk temperature [°C]", "velocity [m/s]", "outcome", *ends
    rows = (
        (
            one.test.get("number"),
            one.test.get("oil") if weighed.oils else None,
            one.test["normal_load"],
            one.test.get("bulk_temperature"),
            one.test["velocity"],
            one.outcome,
            *one.critical_velocity,
        )
        for one in weighed.judged
    )
    return frame_of(heads, rows)


def _describe_contrast(one: Contrast) -> str:
    """Describe in a line how a quantity, such as the critical velocity, differs for two oils."""
    size, unit = (1.0, "K") if one.unit == "K" else (0.01, "%")
    mean, sd, low, high = (
        value / size for value in (one.mean, one.sd, one.interval[0], one.interval[-1])
    )
    signed = f"{mean:+.3g} ± {sd:.2g} {unit} ({low:+.3g} to {high:+.3g})".replace("-", "−")
    first, second = one.oils
    return (
        f"{second} over {first}: {one.what} {signed}; {second} withstands more than {first} with a "
        f"probability of {one.probability:.2g}"
    )


def _summary_frame(weighed: Posterior) -> pd.DataFrame:
    """Frame of mean and standard deviation of each input, before and after the tests [SI]."""
    moments = [(at, moment) for at in ("prior", "posterior") for moment in ("mean", "sd")]
    rows = [
        (row["path"], row["unit"], *(row[at].get(moment) for at, moment in moments))
        for row in weighed.summary()
    ]
    return frame_of(("input", "unit", "before mean", "before sd", "after mean", "after sd"), rows)


def _describe_test(weighed: Posterior, judged: Judged) -> str:
    """Name the test of `judged` in words: number, oil, load, temperature, outcome and velocity."""
    test = judged.test
    oil = f"{test['oil']} " if weighed.oils and "oil" in test else ""
    bulk = ""
    if "bulk_temperature" in test:
        bulk = f" and a bulk of {display(test['bulk_temperature'], '°C')}"
    name = f"test {test['number']}, " if "number" in test else ""
    found = f"{judged.outcome}, at" if test.get("outcome") else "measured"
    return f"{name}{oil}at {test['normal_load']:g} N{bulk} {found} {test['velocity']:g} m/s"
