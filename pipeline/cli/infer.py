"""The command ``irg infer``: critical temperature, or wear rate, from measurements."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict, astuple, replace

import xarray as xr

import pipeline
from pipeline.answers import words
from pipeline.answers.frames import answer_frame
from pipeline.cli.given import flags_of, one_scene_in, stored_tests_of, values_in
from pipeline.cli.output import Result, pluralized, working, wrapped
from pipeline.frames import TABLES, frame_of, records, without_columns, writable_path
from pipeline.quantities import display, shown_in
from pipeline.run.serial import computed_dataset, run_serial
from pipeline.store.create import writing
from pipeline.sweep.sweep import Sweep
from tribo import InputError, Ramp
from tribo.inverse import specific_wear_rate


def infer(options: argparse.Namespace) -> Result:
    """Answer ``irg infer``: infer from measurements what a rig cannot measure.

    A contact width gives the wear rate. Otherwise the tests give the critical temperature.
    """
    sweep = one_scene_in(options)
    if options.output is not None:
        writable_path(options.output, TABLES)
    sweep = sweep._take_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if ignored := values_in(options, "load", "velocity", "duration"):
        raise InputError(f"{flags_of(ignored)} applies only with --contact-width")
    if not sweep.tests:
        raise InputError(
            f"scene {sweep.name} has no tests; add [[tests]] with load, velocity and outcome"
        )
    least = replace(sweep._single_case(), loads=sweep.loads[:1], velocities=sweep.velocities[-1:])
    with working("simulating the tests") as progress, writing(options.store_path, least) as store:
        run_serial(store, source=stored_tests_of(sweep), report=progress)
    ds = computed_dataset(store)
    return _inferred_result(pipeline.infer(ds), pipeline.compare_tests(ds))


def _inferred_result(found: xr.Dataset, tests: xr.Dataset) -> Result:
    """Result for the critical temperature: its value or bound, and the tests."""
    values = {str(name): one.item() for name, one in found.items()}
    count = pluralized(tests.sizes["test"], "test", "tests")
    if not math.isnan(values["at_least"]):
        said = f"critical temperature: at least {display(values['at_least'], '°C', 3)} (95 %)"
    elif not math.isnan(values["at_most"]):
        said = f"critical temperature: at most {display(values['at_most'], '°C', 3)} (95 %)"
    else:
        said = (
            f"critical temperature {display(values['critical_temperature'], '°C', 4)}; standard "
            f"deviation {values['spread_another_rig']:.2g} K for another rig, "
            f"{values['spread_this_rig']:.2g} K for this one"
        )
    frame = answer_frame(tests)
    text = [f"{said}, from {count}", "", without_columns(frame), *words.common_lines(tests)]
    return Result({**values, "tests": records([frame])}, wrapped(text), frames=[frame])


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Result for ``--contact-width``: the specific wear rate that gives this contact width."""
    if options.load is None or options.velocity is None:
        raise InputError("--contact-width also needs --load and --velocity")
    sweep = _hold_for(sweep, options.load, options.duration)
    *_, end = sweep.scene.all_load_steps(options.load)
    with working("searching for the wear rate, one simulation at a time"):
        rate = specific_wear_rate(
            sweep.scene, options.contact_width, options.load, options.velocity
        )
    value, lowest, highest = (shown_in(end, "mm³/(N m)") for end in astuple(rate))
    longer = end.normal_load / (end.impulse + end.normal_load)  # wear goes with load × time
    basis = (
        f"for {end.time:.3g} s of sliding before the width was measured; each further second at "
        f"full load lowers the rate by about {100 * longer:.2g} %"
    )
    if options.duration is None:
        basis += "; use --duration if the test ran longer"
    text = [
        f"specific wear rate {value:.3g} mm³/(N m); {lowest:.3g} to {highest:.3g} if the width "
        "is off by half an element",
        basis,
    ]
    document = asdict(rate) | {"duration": end.time}
    heads = *(f"{name} [mm³/(N m)]" for name in asdict(rate)), "duration [s]"
    return Result(document, text, frames=[frame_of(heads, [tuple(document.values())])])


def _hold_for(sweep: Sweep, load: float, duration: float | None) -> Sweep:
    """Sweep whose tests at `load` [N] last `duration` [s], by a hold; unchanged for None."""
    if duration is None:
        return sweep
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError("--duration applies to load ramps; a recorded load has its own duration")
    ramp = load / sweep.scene.loading.rate
    if duration < ramp:
        raise InputError(
            f"--duration is {duration:g} s, shorter than the ramp to {load:g} N, which takes "
            f"{ramp:g} s"
        )
    return replace(sweep._single_case(), base=sweep.base.held(duration - ramp), tests=())
