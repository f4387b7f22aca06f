"""The command ``irg point``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis.caveats import caveats_of
from pipeline.analysis.margin_frame import judged, margin_frame
from pipeline.analysis.tables import frame_of, transposed
from pipeline.analysis.words import missing_lines
from pipeline.cli.given import one_scene_in
from pipeline.cli.output import Result, working, wrapped
from pipeline.cli.verdicts import place_lines
from pipeline.scene.along import OperatingPoints, Place
from pipeline.scene.facts import require_bearable_load
from pipeline.store.create import writing
from pipeline.store.write import store_path
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, run_point
from pipeline.sweep.stages import Report
from pipeline.sweep.station_choice import choose_stations
from tribo import InputError, TriboError


def point(options: argparse.Namespace) -> Result:
    """Answer ``irg point``: simulate a point and the scene's tests, and judge the point."""
    place = options.load, options.velocity
    sweep = one_scene_in(options)
    require_bearable_load(sweep, options.load, "--load")
    if options.velocity <= 0:
        raise InputError(f"velocity is {options.velocity:g} m/s; give a velocity above 0")
    sweep = replace(sweep.take_surface(options.realization), steps="end")
    places = sweep.take_place(*place, options.alone)
    with store_path(None) as path:
        with working("simulating") as progress, writing(path, places) as store:
            wanted = _points(places, Point(*place), options.alone)
            store.mark_asked(wanted)
            store.commit(_simulate(places, wanted, progress))
        return _margin_result(pipeline.open_sweep(path), Place(*place), options.alone)


def _points(sweep: Sweep, place: Point, alone: bool) -> tuple[Point, ...]:
    """The point to judge, then those of the scene's tests unless `alone`."""
    tests = () if alone else sweep.tests
    return tuple(dict.fromkeys((place, *(Point(one.normal_load, one.velocity) for one in tests))))


def _simulate(sweep: Sweep, points: Sequence[Point], progress: Report) -> Iterator[PointRecord]:
    """Simulate `points` and yield a record of each.

    An error at the first is raised. An error at another is put in its record.
    """
    for point in points:
        try:
            made = run_point(sweep.scene, choose_stations(sweep), point, progress=progress)
            yield made.record(sweep.fields)
        except TriboError as error:
            if point == points[0]:
                raise
            yield PointRecord(point, None, str(error))


def _margin_result(ds: xr.Dataset, place: Place, alone: bool) -> Result:
    """Result of ``irg point``: the verdict on the point, and numbers of its contact.

    `alone` is True if the scene's tests at other loads and velocities are left out.
    """
    data = pipeline.results(ds)
    conditions = data.conditions
    point = ds.sel(load=[place.load], velocity=[place.velocity])
    contact = _contact_frame(point)
    if conditions.critical_temperature is None:
        decides = conditions.contact_temperature(pipeline.results(point).rises(conditions))
        frame = contact = frame_of(_PLACE, [[*place, decides.item()]]).join(contact)
        text = ["mild or severe is not known without temperature.critical"]
    else:
        found = [*judged(data, OperatingPoints((place,), {}))]
        frame, text = margin_frame(data, found).join(contact), place_lines(data, found)
    if alone and data.sweep.tests:
        text.append("tests of the scene at other places are left out, by --alone")
    text += [*missing_lines(data.missing), "", transposed(contact), "", *caveats_of(data)]
    return Result(text=wrapped(text), warned=pipeline.warned(data), frames=[frame])


def _contact_frame(ds: xr.Dataset) -> pd.DataFrame:
    """Frame of one row: the contact at the end of a point, and its temperature over all steps.

    The highest temperature and the failed share are the largest of all steps.
    """
    highest = pipeline.temperatures(ds).max("step")
    both = pipeline.end_of_point(ds).merge(highest, compat="override")
    values = {head: both[name].item() for name, head in _CONTACT.items() if name in both}
    return frame_of([*values], [[*values.values()]])


_PLACE = "load [N]", "velocity [m/s]", "decisive temperature [°C]"
_CONTACT = {
    "max_temperature": "highest temperature [°C]", "failed_fraction": "failed share [%]",
    "pin_heat_share": "pin's heat share [%]", "contact_width": "contact width [µm]",
    "contact_fraction": "contact area [%]", "mean_pressure": "mean pressure [GPa]",
    "max_pressure": "highest pressure [GPa]", "wear_depth_max": "wear depth [µm]",
    "wear_volume": "wear volume [mm³]", "time": "time [s]",
    "sliding_distance": "sliding distance [m]",
}  # fmt: skip
"""Column headings for the contact, by the name of the variable."""
