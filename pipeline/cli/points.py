"""The command ``irg point``."""

from __future__ import annotations

import argparse
from dataclasses import replace

import pandas as pd
import xarray as xr

import pipeline
from pipeline.answers import words
from pipeline.answers.frames import whole_frame
from pipeline.answers.results import sweep_of as scene_sweep
from pipeline.cli.given import one_scene_in, stored_tests_of
from pipeline.cli.output import Result, print_note, working, wrapped
from pipeline.frames import frame_of, transposed
from pipeline.run.serial import computed_dataset, run_serial
from pipeline.scene.contact_estimate import require_admissible_load
from pipeline.store.create import writing
from pipeline.sweep.case import OperatingPoint
from pipeline.sweep.sweep import Point
from tribo import InputError

_BESIDE = (0.8, 1.2)  # velocities of two neighbours over the point's own
_MANY = 8  # points from which on it is said first


def point(options: argparse.Namespace) -> Result:
    """Answer ``irg point``: simulate a point, two beside it and the scene's tests, and judge it."""
    load, velocity = options.load, options.velocity
    sweep = one_scene_in(options)
    require_admissible_load(sweep, load, "--load")
    if velocity <= 0:
        raise InputError(f"velocity is {velocity:g} m/s; it must be above 0")
    velocities = (_BESIDE[0] * velocity, velocity, _BESIDE[1] * velocity)
    places = replace(
        sweep._take_surface(options.realization)._single_case(),
        steps="end",
        loads=(load,),
        velocities=velocities,
        tests=() if options.without_tests else sweep.tests,
    )
    source = stored_tests_of(sweep) if places.tests else None
    count = len(velocities) + sum(len(one.places) for one in places.tests)
    if source is None and count > _MANY:
        print_note(f"{count} points will be simulated, including those of tests")
    with working("simulating") as progress, writing(None, places) as store:
        wanted = [Point(load, each) for each in (velocity, velocities[0], velocities[2])]
        run_serial(store, wanted, source, progress)
    return _margin_result(computed_dataset(store), (load, velocity))


def _margin_result(ds: xr.Dataset, place: OperatingPoint) -> Result:
    """Result of ``irg point``: the verdict on the point, and numbers of its contact."""
    contact = _contact_frame(ds.sel(load=[place[0]], velocity=[place[1]]))
    if not scene_sweep(ds).base.is_judged:
        text, frame = ["without temperature.critical there is no verdict"], contact
    else:
        found = pipeline.margin(ds, *place)
        text = [*words.margin_lines(found), *words.common_lines(found)]
        frame = whole_frame(found).join(contact)
    text += ["", transposed(contact)]
    return Result(text=wrapped(text), warned=pipeline.points_with_warnings(ds), frames=[frame])


def _contact_frame(ds: xr.Dataset) -> pd.DataFrame:
    """Frame of one row: the contact at the end of a point, and its hottest over all steps."""
    highest = pipeline.temperatures(ds).max("step")
    both = pipeline.end_of_point(ds).merge(highest, compat="override")
    values = {head: both[name].item() for name, head in _CONTACT.items() if name in both}
    return frame_of([*values], [[*values.values()]])


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
