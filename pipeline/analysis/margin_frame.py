"""Margins of operating points: of one, of a table, or of the rows of a sweep."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
import pandas as pd

from pipeline.analysis.dataset import Layout, require_kind
from pipeline.analysis.field import PointField, point_field
from pipeline.analysis.laboratory import model_error, tests_beside
from pipeline.analysis.margin import Margin, answers, clipped
from pipeline.analysis.model_error import ModelError
from pipeline.analysis.results import Results, ResultsLike, results
from pipeline.analysis.scenes import heads_of, shown_label
from pipeline.analysis.tables import frame_of
from pipeline.quantities import column_heads, snap
from pipeline.scene.along import OperatingPoints, Place
from pipeline.scene.doubts import doubts_of_row
from pipeline.scene.units import in_si
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.remarks import join_notes
from pipeline.sweep.variants import VARIANT
from tribo import InputError

Points = OperatingPoints | PathLike | Mapping[str, Sequence[Any]]
"""Operating points: already read, in a file, or as columns by heading."""


@overload
def margin(ds: ResultsLike, load: Any, velocity: float | str) -> Margin | pd.DataFrame: ...


@overload
def margin(ds: ResultsLike, load: Points | None = None) -> pd.DataFrame: ...


@np.errstate(under="ignore")
def margin(ds: ResultsLike, load: Any = None, velocity: Any = None) -> Margin | pd.DataFrame:
    """Judge operating points without a new simulation: verdict, and distance from severe wear.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or the path of a store. Points that are
        pending or failed are skipped.
    load : float or str
        Normal load on the whole pin [N], or text such as ``"500 N"``, within the sweep's loads.
        Instead of load and velocity it may be a table of operating points: a .csv or .xlsx file
        with columns ``load [N]`` and ``velocity [m/s]``, or with other units; or columns by
        heading, such as a data frame. Columns ``friction``, ``bulk_temperature`` and
        ``critical_temperature`` are conditions of a row. Further columns are copied to the result,
        with "(given)" added to a heading that the result already has. Leave load and velocity out
        if the sweep's rows have their own.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit, above 0 and within the sweep's velocities.

    Returns
    -------
    Margin or DataFrame
        For one operating point in a single scene its `Margin`. Otherwise a data frame with a row
        for each point: load, velocity, the ``verdict`` on a further run, the ``probability`` that
        it is severe, the contact temperature that the criterion compares with the critical
        temperature (``decisive temperature [°C]``), its numerical ``temperature error [K]``, and
        its ``distance [K]`` below the critical temperature. For velocity and for load it also has
        the lowest critical value, its ratio to the point's own value, and the outcome. With several
        surfaces these values are medians; ``distance low [K]`` and
        ``distance high [K]`` are the 5 and 95 % quantiles. Points outside the computed ones have no
        values, and ``notes`` give the reason.

    Raises
    ------
    InputError
        If a single operating point is outside the sweep, or too few points are done for it; or if
        the table has faults, all of which the message names.

    Examples
    --------
    >>> import pipeline
    >>> here = pipeline.margin("results/first_try.zarr", "400 N", "1.4 m/s")
    >>> here.verdict, f"{here.distance:.0f} K"
    ('mild', '30 K')
    >>> points = {"load": ["400 N", "600 N"], "velocity": ["1.4 m/s", "2.4 m/s"]}
    >>> pipeline.margin("results/first_try.zarr", points)[["load [N]", "verdict"]]
       load [N] verdict
    0     400.0    mild
    1     600.0  severe
    """
    data = results(ds)
    points = load
    if (load is None or isinstance(load, float | int)) and (load is None) != (velocity is None):
        raise InputError("load and velocity go together; give both")
    if velocity is not None:
        place = Place(in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s"))
        points = OperatingPoints((place,), {})
    elif not (load is None or isinstance(load, OperatingPoints)):
        points = OperatingPoints.read(load)
    found = [*judged(data, points)]
    if velocity is not None and len(found) == 1:
        return found[0].known()
    return margin_frame(data, found, points)


class Judged(NamedTuple):
    """An operating point in one scene, with its `Margin` or the reason why that is unknown."""

    field: PointField  # field under the conditions of the operating point
    place: Place
    own: Mapping[str, float]  # conditions given in the row of a table
    margin: Margin | None
    reason: str = ""

    def known(self) -> Margin:
        """The margin; raises an `InputError` if it is unknown."""
        if self.margin is None:
            raise InputError(self.reason)
        return self.margin


def judged(data: Results, points: OperatingPoints | None) -> Iterator[Judged]:
    """Judge operating points for each variant of a sweep; yield one `Judged` per point and variant.

    A variant is one combination of values of the varied entries. If `points` is None, each variant
    is judged at the load and velocity for which it was computed. An `InputError` is raised if these
    are not a single pair, as in a sweep with a grid of loads and velocities.
    """
    if points is not None:
        require_kind(data.kind, Layout.PLANE)
    for field in map(point_field, data.scenes):
        scatter = model_error(field.source, field)
        place = field.source.place
        if points is None and place is None:
            raise InputError(
                "no operating point is given, and rows of the sweep have none; give a load and a "
                "velocity (--load and --velocity), or a table of them (--points)"
            )
        own_place = [(Place(*place), dict[str, float]())] if place else []
        places = [*(points.rows if points else own_place)]
        for begin in range(0, len(places), field.at_once):
            yield from _judged_points(field, places[begin : begin + field.at_once], scatter)


def _judged_points(
    field: PointField, points: Sequence[tuple[Place, Mapping[str, float]]], scatter: ModelError
) -> list[Judged]:
    """Judge operating points of one scene: whether wear is severe there, and how far from it.

    Returns a `Judged` for each point, in the order of `points`. Each of `points` is a pair: its
    load [N] and velocity [m/s], and by name the conditions of this point alone, such as its
    friction. `field` gives the temperature rise at any point of the scene. `scatter` is the
    distribution of the model's error of the critical velocity.
    """
    found, alike = dict[int, Judged](), dict[tuple[Any, ...], list[int]]()
    for number, (_, own) in enumerate(points):
        alike.setdefault((*own.items(),), []).append(number)
    for conditions, numbers in alike.items():
        here, own = [points[number][0] for number in numbers], dict(conditions)
        try:
            under = field.judged_by(own)
            met = [
                [snap(x, *under.ends[name]) for name, x in zip(PLANE, place, strict=True)]
                for place in here
            ]
            tested = [[*tests_beside(field.source, *place)] for place in met]
            loads, velocities = np.array(met).T
            margins = answers(under, loads, velocities, scatter, tested)
        except InputError as error:
            under, margins = field, [str(error)] * len(here)
        for number, place, margin in zip(numbers, here, margins, strict=True):
            answer = (None, margin) if isinstance(margin, str) else (margin, "")
            found[number] = Judged(under, place, own, *answer)
    return [found[number] for number in range(len(points))]


def margin_frame(
    data: Results, found: Sequence[Judged], points: OperatingPoints | None = None
) -> pd.DataFrame:
    """Data frame with a row for each judged operating point in `found`.

    Varied entries, and further columns of the user's `points`, come first.
    """
    names = _label_names(found) if data.kind is Layout.PLACES else data.entry_dims
    heads = heads_of(data.rows, names)
    labels = pd.DataFrame(
        {
            head: [shown_label(data.rows[name], one.field.source.labels[name]) for one in found]
            for name, head in heads.items()
        }
    )
    rows = []
    for one in found:
        notes = [*doubts_of_row(one.own)]
        if one.margin is None:
            values = ["not known", *[None] * (len(_COLUMNS) - 1)]
            notes.insert(0, one.reason)
        else:
            values = [_value(one.margin, name) for name in _COLUMNS]
            notes += one.margin.caveats
        rows.append((*one.place, *values, join_notes(notes)))
    answers = frame_of(("load [N]", "velocity [m/s]", *_COLUMNS.values(), "notes"), rows)
    return pd.concat([labels, _copied_columns(points, answers), answers], axis="columns")


_COLUMNS = column_heads(
    "verdict", "probability", "decisive_temperature", "temperature_error", "distance",
    "distance_low", "distance_high", "velocity_factor", "critical_velocity", "velocity_outcome",
    "load_factor", "critical_load", "load_outcome",
)  # fmt: skip
"""Column headings by the name of the attribute of `Margin`, or of an end of its interval."""
LONG = (
    "temperature error [K]", "distance low [K]", "distance high [K]", "critical velocity [m/s]",
    "critical load [N]", "velocity outcome", "load outcome", "notes",
)  # fmt: skip
"""Columns left out on a terminal or a page, which are too narrow."""


def _value(margin: Margin, name: str) -> Any:
    if name in ("distance_low", "distance_high"):
        return margin.intervals.get("distance", (math.nan, math.nan))[name == "distance_high"]
    value = getattr(margin, name)
    return clipped(value) if name == "probability" else value


def _label_names(found: Sequence[Judged]) -> list[str]:
    """Names of the coordinates that identify the operating points `found`.

    The number of a row of the sweep's table is left out, unless there is nothing else.
    """
    names = [name for one in found[:1] for name in one.field.source.labels]
    return [name for name in names if name != VARIANT] or names


def _copied_columns(points: OperatingPoints | None, answers: pd.DataFrame) -> pd.DataFrame:
    """Frame of the columns of the user's table `points` other than load and velocity.

    The frame has the rows of `answers`, in which the operating points are repeated for each scene.
    A heading that `answers` already has gets the suffix "(given)". If `points` is None, the frame
    has no columns.
    """
    taken, count = {*answers}, len(answers)
    columns = {
        f"{head} (given)" if head in taken else head: [*values] * (count // len(values))
        for head, values in (points.others.items() if points else ())
    }
    return pd.DataFrame(columns, index=answers.index)


def counts_in_words(frame: pd.DataFrame) -> str:
    """Numbers of operating points by verdict, and the point with the least margin, in words.

    The point is left out if it is the only one, or no margin is known.
    """
    counts = Counter(frame["verdict"])
    said = ", ".join(f"{number} {verdict}" for verdict, number in sorted(counts.items()))
    if len(frame) == 1 or frame["distance [K]"].isna().all():
        return said
    least = frame.loc[frame["distance [K]"].astype(float).idxmin()]
    place = f"{least['load [N]']:g} N and {least['velocity [m/s]']:g} m/s"
    return f"{said}; the least margin is {least['distance [K]']:.3g} K, at {place}"
