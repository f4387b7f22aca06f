"""The commands ``irg point`` and ``irg infer``, which simulate a few points in this process."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict, astuple, replace

import pandas as pd
import xarray as xr

import pipeline
from pipeline.answers import words
from pipeline.answers.frames import answer_frame, whole_frame
from pipeline.answers.results import sweep_of
from pipeline.cli.given import one_scene_in, stored_tests_of
from pipeline.cli.output import Result, pluralized, print_note, working, wrapped
from pipeline.frames import frame_of, records, transposed, without_columns
from pipeline.quantities import display, shown_in
from pipeline.run.serial import computed_dataset, run_serial
from pipeline.scene.contact_estimate import require_admissible_load
from pipeline.store.create import writing
from pipeline.sweep.sweep import Point, Sweep
from tribo import InputError, Ramp
from tribo.inverse import specific_wear_rate

_BESIDE = (0.8, 1.2)  # velocities of two neighbours over the point's own
_MANY = 8  # points from which on it is said first
_CONTACT = {
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
    """Answer ``irg point``: simulate a point, two beside it and the scene's tests, and judge it."""
    load, velocity = options.load, options.velocity
    sweep = one_scene_in(options)
    require_admissible_load(sweep, load, "--load")
    velocities = (_BESIDE[0] * velocity, velocity, _BESIDE[1] * velocity)
    places = replace(
        sweep._take_surface(options.realization)._single_case(),
        steps="end",
        loads=(load,),
        velocities=velocities,
        tests=() if options.without_tests else sweep.tests,
    )
    source = stored_tests_of(sweep) if places.tests else None
    count = len(velocities) + sum(len(one.points) for one in places.tests)
    if source is None and count > _MANY:
        print_note(f"{count} points will be simulated, including those of tests")
    with working("simulating") as progress, writing(None, places) as store:
        wanted = [Point(load, each) for each in (velocity, velocities[0], velocities[2])]
        run_serial(store, wanted, source, progress)
    ds = computed_dataset(store)
    contact = _contact_frame(ds.sel(load=[load], velocity=[velocity]))
    text, frame = ["without temperature.critical there is no verdict"], contact
    if sweep_of(ds).base.is_judged:
        found = pipeline.margin(ds, load, velocity)
        text = [*words.margin_lines(found), *words.common_lines(found)]
        frame = whole_frame(found).join(contact)
    warned = pipeline.points_with_warnings(ds)
    return Result(text=wrapped([*text, "", transposed(contact)]), warned=warned, frames=[frame])


def _contact_frame(ds: xr.Dataset) -> pd.DataFrame:
    """Frame of one row: the contact at the end of a point, and its hottest over all steps."""
    highest = pipeline.temperatures(ds).max("step")
    both = pipeline.end_of_point(ds).merge(highest, compat="override")
    values = {head: both[name].item() for name, head in _CONTACT.items() if name in both}
    return frame_of([*values], [[*values.values()]])


def infer(options: argparse.Namespace) -> Result:
    """Answer ``irg infer``: infer from measurements what a rig cannot measure.

    A contact width gives the wear rate. Otherwise the tests give the critical temperature.
    """
    sweep = one_scene_in(options)._take_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if any(one is not None for one in (options.load, options.velocity, options.duration)):
        raise InputError("--load, --velocity and --duration apply only with --contact-width")
    if not sweep.tests:
        raise InputError(
            f"scene {sweep.name} has no tests; add [[tests]] with load, velocity and outcome"
        )
    least = replace(sweep._single_case(), loads=sweep.loads[:1], velocities=sweep.velocities[-1:])
    with working("simulating the tests") as progress, writing(None, least) as store:
        run_serial(store, source=stored_tests_of(sweep), report=progress)
    ds = computed_dataset(store)
    tests, values = pipeline.compare_tests(ds), pipeline.infer(ds)
    found = {str(name): one.item() for name, one in values.items()}
    said = (
        f" {display(found['critical_temperature'], '°C', 4)}; standard deviation "
        f"{found['spread_another_rig']:.2g} K for another rig, {found['spread_this_rig']:.2g} K "
        "for this one"
    )
    for bound in ("at_least", "at_most"):
        if not math.isnan(found[bound]):
            said = f": {bound.replace('_', ' ')} {display(found[bound], '°C', 3)} (95 %)"
    count = pluralized(tests.sizes["test"], "test", "tests")
    frame = answer_frame(tests)
    text = [
        f"critical temperature{said}, from {count}", "", without_columns(frame),
        *words.common_lines(tests),
    ]  # fmt: skip
    return Result({**found, "tests": records([frame])}, wrapped(text), frames=[frame])


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> Result:
    """Result for ``--contact-width``: the specific wear rate that gives this contact width."""
    load = options.load
    if load is None or options.velocity is None:
        raise InputError("--contact-width also needs --load and --velocity")
    if options.duration is not None:
        sweep = _hold_for(sweep, load, options.duration)
    *_, end = sweep.scene.all_load_steps(load)
    with working("searching for the wear rate, one simulation at a time"):
        rate = specific_wear_rate(sweep.scene, options.contact_width, load, options.velocity)
    value, lowest, highest = (shown_in(one, "mm³/(N m)") for one in astuple(rate))
    longer = end.normal_load / (end.impulse + end.normal_load)  # wear goes with load × time
    text = [
        f"specific wear rate {value:.3g} mm³/(N m); {lowest:.3g} to {highest:.3g} if the width "
        "is off by half an element",
        f"for {end.time:.3g} s of sliding before the width was measured; each further second at "
        f"full load lowers the rate by about {100 * longer:.2g} %"
        + "; use --duration if the test ran longer"
        * (options.duration is None),
    ]
    document = asdict(rate) | {"duration": end.time}
    heads = *(f"{name} [mm³/(N m)]" for name in asdict(rate)), "duration [s]"
    return Result(document, text, frames=[frame_of(heads, [tuple(document.values())])])


def _hold_for(sweep: Sweep, load: float, duration: float) -> Sweep:
    """Sweep whose tests at `load` [N] last `duration` [s], by a hold."""
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError("--duration applies to load ramps; a recorded load has its own duration")
    ramp = load / sweep.scene.loading.rate
    if duration < ramp:
        raise InputError(
            f"--duration is {duration:g} s, shorter than the ramp to {load:g} N, which takes "
            f"{ramp:g} s"
        )
    return replace(sweep._single_case(), base=sweep.base.with_hold(duration - ramp), tests=())
