"""The command ``irg infer``: critical temperature, or wear rate, from measurements."""

from __future__ import annotations

import argparse
from dataclasses import asdict, astuple

import pandas as pd

import pipeline
from pipeline.analysis.tables import TABLES, frame_of, short, writable_path
from pipeline.cli.given import flags_of, one_scene_in, values_in
from pipeline.cli.output import Result, counted, run_line, working
from pipeline.quantities import display, shown_in
from pipeline.sweep.condition_words import unmodelled_rise_words
from pipeline.sweep.model import Sweep
from pipeline.tradeoff.critical_temperature import CriticalTemperatures, as_transitions
from tribo import InputError, Ramp
from tribo.inverse import specific_wear_rate


def infer(options: argparse.Namespace) -> Result:
    """Answer ``irg infer``: infer from measurements what a rig cannot measure.

    A contact width gives the wear rate. Otherwise the tests give the critical temperature.
    """
    return _scene_result(options, one_scene_in(options))


def _scene_result(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Result of ``irg infer`` for a scene file.

    The result is the wear rate, if a contact width is given, else the critical temperature.
    """
    if options.output is not None:
        writable_path(options.output, TABLES)
    sweep = sweep.take_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if ignored := values_in(options, "load", "velocity", "duration"):
        raise InputError(f"{flags_of(ignored)} belongs to --contact-width, which is not given")
    tested = () if sweep.measured else sweep.tested
    sweep = as_transitions(sweep) if tested else sweep
    with run_line() as progress:
        inferred = pipeline.critical_temperatures(
            sweep, out=options.kept, workers=options.workers, progress=progress
        )
    frame = _transition_frame(inferred)
    beside = [words] if (words := unmodelled_rise_words(sweep.conditions)) else []
    if tested:
        outcomes = [str(test.outcome) for test in tested]
        return _bounds_result(inferred, outcomes, frame, beside)
    measured = counted(len(frame), "measured transition", "measured transitions")
    several = f" on {len(inferred.surfaces)} surfaces" if len(inferred.surfaces) > 1 else ""
    apart = f", {inferred.spread:.1f} K apart (standard deviation)" if inferred.spread else ""
    text = [
        f"critical temperature from {measured}{several}: {inferred.criterion.temperature}",
        short(frame),
        f"on average {display(inferred.mean, '°C', 4)}{apart}",
        *beside,
    ]
    return Result(inferred.as_dict(), text, frames=[frame])


def _bounds_result(
    at_tests: CriticalTemperatures, outcomes: list[str], frame: pd.DataFrame, beside: list[str]
) -> Result:
    """Result of ``irg infer`` for tests with an outcome: bounds of the critical temperature.

    `at_tests` has the simulated temperature at each test, and `outcomes` is "mild" or "severe" for
    each test. `frame` is the table to print, with a row for each test; it gets their outcomes as a
    new column. `beside` has lines to print last.
    """
    judged = list(zip(outcomes, at_tests.means, strict=True))
    low = max((mean for outcome, mean in judged if outcome == "mild"), default=None)
    high = min((mean for outcome, mean in judged if outcome == "severe"), default=None)
    above, below = (end and display(end, "°C", 4) for end in (low, high))
    if low is None or high is None:
        side = "below" if low is None else "above"
        bounds = f"the critical temperature is {side} {above or below}"
    elif low < high:
        bounds = f"the critical temperature is between {above} and {below}"
    else:
        bounds = f"the tests contradict each other: mild up to {above}, severe from {below} on"
    frame.insert(3, "outcome", outcomes)
    frame = frame.rename(columns={"critical temperature [°C]": "temperature [°C]"})
    text = [
        f"temperature of {counted(len(outcomes), 'test', 'tests')}, below the critical "
        "temperature where wear stayed mild, above it where wear turned severe:",
        short(frame),
        bounds,
        *beside,
    ]
    document = at_tests.as_dict() | {"outcomes": outcomes, "bounds": [low, high]}
    return Result(document, text, frames=[frame])


def _transition_frame(inferred: CriticalTemperatures) -> pd.DataFrame:
    """Data frame with a row for each transition: load, velocity, friction, critical temperature.

    With several random surfaces, the temperature is their mean. Further columns have the standard
    deviation between surfaces, and the temperature on each.
    """
    seeds = inferred.surfaces if inferred.spreads[0] else ()
    heads = (
        *("load [N]", "velocity [m/s]", "friction", "critical temperature [°C]", "spread [K]"),
        *(f"surface {seed} [°C]" for seed in seeds),
    )
    rows = zip(
        inferred.transitions, inferred.temperatures, inferred.means, inferred.spreads, strict=True
    )
    return frame_of(
        heads,
        (
            (test.normal_load, test.velocity, test.friction, mean, spread, *(seeds and values))
            for test, values, mean, spread in rows
        ),
    )


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Result for ``--contact-width``: the specific wear rate that gives this contact width."""
    if options.load is None or options.velocity is None:
        raise InputError("--contact-width needs a load and a velocity; give --load and --velocity")
    sweep = _hold_for(sweep, options.load, options.duration)
    *_, end = sweep.scene.all_stations(options.load)
    with working("seeking the wear rate, one simulation after the other"):
        rate = specific_wear_rate(
            sweep.scene, options.contact_width, options.load, options.velocity
        )
    value, lowest, highest = (shown_in(end, "mm³/(N m)") for end in astuple(rate))
    longer = end.normal_load / (end.impulse + end.normal_load)  # wear goes with load × time
    basis = (
        f"for {end.time:.3g} s of sliding until the width was measured; each further second at "
        f"full load lowers the rate by about {100 * longer:.2g} %"
    )
    if options.duration is None:
        basis += ": give --duration, if the test went on"
    text = [
        f"specific wear rate {value:.3g} mm³/(N m), from {lowest:.3g} to {highest:.3g} within half "
        "an element of the width",
        basis,
    ]
    document = asdict(rate) | {"duration": end.time}
    heads = *(f"{name} [mm³/(N m)]" for name in asdict(rate)), "duration [s]"
    return Result(document, text, frames=[frame_of(heads, [tuple(document.values())])])


def _hold_for(sweep: Sweep, load: float, duration: float | None) -> Sweep:
    """Sweep in which `load` [N] is held after its ramp, so that a test lasts `duration` [s].

    If `duration` is None, the sweep is returned unchanged. Raises an `InputError` if the ramp alone
    lasts longer than `duration`, or if the load does not grow by a ramp, but follows a measured
    record.
    """
    if duration is None:
        return sweep
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError("--duration holds a ramp; a recorded load ends where the record does")
    ramp = load / sweep.scene.loading.rate
    if duration < ramp:
        raise InputError(
            f"--duration is {duration:g} s; it must be at least the {ramp:g} s of the ramp to "
            f"{load:g} N"
        )
    return sweep.with_hold(duration - ramp)
