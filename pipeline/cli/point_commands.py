"""The commands ``irg point`` and ``irg infer``, which simulate a few points in this process."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict, astuple, replace

import pandas as pd
import xarray as xr

import pipeline
from pipeline.answers.answer_frames import answer_frame, comparison_frame, complete_frame
from pipeline.answers.condition_values import override_conditions
from pipeline.answers.facts import NOTES, fact_lines, point_lines
from pipeline.answers.results import sweep_of
from pipeline.answers.value_text import format_value, join_texts, split_texts
from pipeline.answers.verdict_model import omission_of_tests
from pipeline.cli.inputs import conditions_in, one_scene_in, stored_tests_of
from pipeline.cli.output import Result, print_note, run_line, wrapped
from pipeline.frames import frame_of, records, transposed, without_columns
from pipeline.messages import pluralized
from pipeline.quantities import display, in_unit
from pipeline.run.serial import run_serial
from pipeline.scene.contact_estimate import require_admissible_load
from pipeline.shipped import typed_name
from pipeline.store.create import writing
from pipeline.store.dataset import store_dataset
from pipeline.sweep.sweep import Point, Sweep
from tribo import InputError, Ramp
from tribo.inverse import specific_wear_rate

_MODEL = (
    "it holds only for {}; infer it again for another one: tests of two rigs gave 5 to 7 K more on "
    "a random surface than on a measured one, and 18 to 30 K more with wear pattern swept than "
    "with local"
)
_CONTACT_HEADINGS = {
    "max_temperature": "highest temperature [°C]",
    "failed_area_fraction": "failed area fraction [%]",
    "pin_heat_share": "heat into the pin [%]", "contact_width": "contact width [µm]",
    "contact_fraction": "real contact area of the window [%]",
    "mean_pressure": "mean pressure [GPa]",
    "max_pressure": "highest pressure [GPa]", "wear_depth_max": "wear depth [µm]",
    "wear_volume": "wear volume [mm³]", "time": "time [s]",
    "sliding_distance": "sliding distance [m]",
}  # fmt: skip
"""Column headings for the contact, by the name of the variable."""


def point(options: argparse.Namespace) -> Result:
    """Answer ``irg point``: simulate a point, its two neighbours and the tests; judge it."""
    load, velocity = options.load, options.velocity
    sweep = one_scene_in(options)
    require_admissible_load(sweep, load, "--load")
    critical = {k: x for k, x in conditions_in(options).items() if k == "critical_temperature"}
    conditions = override_conditions(sweep.single_case().conditions, critical)
    has_tests = bool(sweep.tests) and not options.without_tests
    omission = omission_of_tests(sweep, conditions) if has_tests else ""
    lower, higher = 0.8 * velocity, 1.2 * velocity
    point_sweep = replace(
        sweep.take_surface(options.realization).single_case(),
        steps="end",
        loads=(load,),
        velocities=(lower, velocity, higher),
        tests=sweep.tests if has_tests and not omission else (),
    )
    source = stored_tests_of(sweep) if point_sweep.tests else None
    count = 3 + sum(len(test.points) for test in point_sweep.tests)
    if source is None and count > 8:
        print_note(f"{count} points will be simulated, including those of tests")
    with run_line(2.0) as progress, writing(None, point_sweep) as store:
        ordered_points = [Point(load, speed) for speed in (velocity, lower, higher)]
        run_serial(store, ordered_points, source, progress)
    ds = store_dataset(store).load()
    contact = _contact_frame(ds.sel(load=[load], velocity=[velocity]))
    text, frame = ["without temperature.critical there is no verdict"], contact
    if critical or sweep_of(ds).base.is_judged:
        margins = pipeline.margin(ds, load, velocity, **critical)
        notes = join_texts(split_texts([omission, margins.attrs["notes"]]))
        margins = margins.assign_attrs(notes=notes)
        text = [
            *point_lines(margins, has_ends=False),
            f"only {lower:.4g}, {velocity:.4g} and {higher:.4g} m/s were simulated at this load; "
            f"for limits beyond them: irg run {typed_name(sweep.name)}",
            *fact_lines(margins, *NOTES),
        ]
        frame = complete_frame(margins).join(contact)
    warnings = pipeline.points_with_warnings(ds).lines()
    return Result(text=wrapped([*text, "", transposed(contact), *warnings]), frames=[frame])


def _contact_frame(ds: xr.Dataset) -> pd.DataFrame:
    """Frame of one row: the contact at the end of a point, and its highest temperatures."""
    highest = pipeline.temperatures(ds).max("step")
    contact = pipeline.end_of_point(ds).merge(highest, compat="override")
    values = {
        heading: contact[name].item()
        for name, heading in _CONTACT_HEADINGS.items()
        if name in contact
    }
    return frame_of([*values], [[*values.values()]])


def infer(options: argparse.Namespace) -> Result:
    """Answer ``irg infer``: infer from measurements what a rig cannot measure.

    A contact width gives the wear rate. Otherwise the tests give the critical temperature.
    """
    sweep = one_scene_in(options).take_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if any(option is not None for option in (options.load, options.velocity, options.duration)):
        raise InputError("--load, --velocity and --duration apply only with --contact-width")
    if not sweep.tests:
        raise InputError(
            f"scene {sweep.name} has no tests; add [[tests]] with load, velocity and outcome"
        )
    small_sweep = replace(
        sweep.single_case(), loads=sweep.loads[:1], velocities=sweep.velocities[-1:]
    )
    with run_line(2.0) as progress, writing(None, small_sweep) as store:
        run_serial(store, source=stored_tests_of(sweep), report=progress)
    ds = store_dataset(store).load()
    tests, values = pipeline.compare_tests(ds), pipeline.infer(ds)
    result = {str(name): value.item() for name, value in values.items()}
    count = pluralized(tests.sizes["test"], "test", "tests")
    celsius = in_unit(result["critical_temperature"], "°C")
    finding = (
        f"critical temperature {format_value(celsius, result['spread_this_rig'])} °C; standard "
        f"deviation {result['spread_another_rig']:.2g} K for another rig, "
        f"{result['spread_this_rig']:.2g} K for this one, from {count}"
    )
    for name in ("at_least", "at_most"):  # by tests of a single outcome
        if not math.isnan(result[name]):
            bound = f"{name.replace('_', ' ')} {display(result[name], '°C', 3)}"
            finding = f"critical temperature: {bound} (95 %), from {count}"
    frame = answer_frame(tests)
    validity = _MODEL.format(values.attrs["model"])
    table = without_columns(comparison_frame(tests))
    text = [finding, validity, "", table, *fact_lines(tests, *NOTES)]
    result["model"] = values.attrs["model"]
    return Result({**result, "tests": records([frame])}, wrapped(text), frames=[frame])


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Result for ``--contact-width``: the specific wear rate that gives this contact width."""
    load = options.load
    if load is None or options.velocity is None:
        raise InputError("--contact-width also needs --load and --velocity")
    if options.duration is not None:
        sweep = _hold_for(sweep, load, options.duration)
    *_, end = sweep.scene.all_load_steps(load)
    print_note("searching for the wear rate, one simulation at a time …")
    rate = specific_wear_rate(sweep.scene, options.contact_width, load, options.velocity)
    value, lowest, highest = (in_unit(limit, "mm³/(N m)") for limit in astuple(rate))
    fraction_per_second = end.normal_load / (end.impulse + end.normal_load)
    basis = (
        f"for {end.time:.3g} s of sliding before the width was measured; each further second at "
        f"full load lowers the rate by about {100 * fraction_per_second:.2g} %"
    )
    if options.duration is None:
        basis = f"{basis}; use --duration if the test ran longer"
    text = [
        f"specific wear rate {value:.3g} mm³/(N m); {lowest:.3g} to {highest:.3g} if the width "
        "is off by half an element",
        basis,
    ]
    document = asdict(rate) | {"duration": end.time}
    headings = *(f"{name} [mm³/(N m)]" for name in asdict(rate)), "duration [s]"
    return Result(document, text, frames=[frame_of(headings, [tuple(document.values())])])


def _hold_for(sweep: Sweep, load: float, duration: float) -> Sweep:
    """Sweep whose tests at `load` [N] last `duration` [s], by a hold."""
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError("--duration applies to load ramps; a recorded load has its own duration")
    ramp_time = load / sweep.scene.loading.rate
    if duration < ramp_time:
        raise InputError(
            f"--duration is {duration:g} s, shorter than the ramp to {load:g} N, which takes "
            f"{ramp_time:g} s"
        )
    return replace(sweep.single_case(), base=sweep.base.with_hold(duration - ramp_time), tests=())
