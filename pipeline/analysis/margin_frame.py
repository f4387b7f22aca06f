"""Margins of operating points: of one, of a table, or of the rows of a sweep."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple, Unpack, overload

import numpy as np
import pandas as pd

from pipeline.analysis.at import ConditionKeywords, asked_at
from pipeline.analysis.caveats import scene_caveats
from pipeline.analysis.condition_words import verdict_conditions
from pipeline.analysis.dataset import Layout, require_kind
from pipeline.analysis.film import OUTSIDE_WORDS, inside_alone, turns_inside
from pipeline.analysis.judge import Judge, judge_of
from pipeline.analysis.margin import AT_EDGE, PASSED, Margin
from pipeline.analysis.operating_points import OperatingPoints, doubts_of_row
from pipeline.analysis.reading import ResultsLike
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import RiseError, rise_errors
from pipeline.analysis.scenes import heads_of, shown_label
from pipeline.analysis.specimen import counted
from pipeline.analysis.tables import frame_of
from pipeline.analysis.tested import tests_beside, waiting_words
from pipeline.quantities import column_heads, snap
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.case import Place
from pipeline.sweep.conditions import known_critical_temperature
from pipeline.sweep.variants import VARIANT
from pipeline.table import Column
from pipeline.units import in_si, to_si
from pipeline.words import join_notes
from tribo import InputError, WarningKind
from tribo.types import Array

_AT_ONCE = 2000  # operating points judged in one call, with some 100 MB of memory

Points = OperatingPoints | PathLike | Mapping[str, Sequence[Any]]
"""Operating points: already read, in a file, or as columns by heading."""


@overload
def margin(
    ds: ResultsLike,
    load: float | str,
    velocity: float | str,
    **conditions: Unpack[ConditionKeywords],
) -> Margin: ...


@overload
def margin(
    ds: ResultsLike, load: Points | None = None, **conditions: Unpack[ConditionKeywords]
) -> pd.DataFrame: ...


@np.errstate(under="ignore")
def margin(
    ds: ResultsLike,
    load: Any = None,
    velocity: Any = None,
    **conditions: Unpack[ConditionKeywords],
) -> Margin | pd.DataFrame:
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
        heading, such as a data frame. Columns ``friction``, ``bulk_temperature``,
        ``critical_temperature`` and ``failing_share`` are conditions of a row. Further columns are
        copied to the result, with "(given)" added to a heading that the result already has. Leave
        load and velocity out if the sweep's rows have their own.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit, above 0 and within the sweep's velocities.
    **conditions
        Conditions to judge by, as in `pipeline.at`, such as ``friction=0.12``.

    Returns
    -------
    Margin or DataFrame
        For one operating point, given by load and velocity, its `Margin`. Otherwise a data frame
        with a row for each point of each scene: load, velocity, the ``verdict`` on a further run,
        the ``probability`` that it is severe, the contact temperature that the criterion compares
        with the critical temperature (``deciding temperature [°C]``), its numerical ``temperature
        error [K]`` and the part of the surface in it, and its ``distance [K]`` below the critical
        temperature. For velocity and for load it also has
        the lowest critical value, its ratio to the point's own value, and the outcome; and ``with
        tests [m/s]``, the velocity at which severe wear is 50 % likely. Points outside the computed
        ones have no values, and ``notes`` give the reason.

    Raises
    ------
    InputError
        If a single operating point is outside the sweep, too few points are done for it, or the
        sweep has several scenes; or if the table has faults, all of which the message names.

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
    data = asked_at(ds, conditions)
    points = load
    if (load is None or _is_quantity(load)) and (load is None) != (velocity is None):
        raise InputError("load and velocity go together; give both")
    if velocity is not None:
        place = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
        points = OperatingPoints((place,), {})
    elif not (load is None or isinstance(load, OperatingPoints)):
        points = OperatingPoints.read(load)
    found = [*asked_of(data, points)]
    if velocity is not None:
        if len(found) > 1:
            raise InputError(
                f"the sweep has {len(found)} scenes, by {' and '.join(data.entry_dims)}; select "
                "one by pipeline.at, or give the place as a table, for a row of each scene: "
                '{"load": [...], "velocity": [...]}'
            )
        return found[0].known()
    return margin_frame(data, found, points)


class Asked(NamedTuple):
    """An operating point asked of one scene: its `Margin`, or why that is unknown."""

    source: Results  # results of the scene
    place: Place
    own: Mapping[str, float]  # conditions given in the row of a table
    margin: Margin | None
    reason: str = ""

    def known(self) -> Margin:
        """The margin; raises an `InputError` if it is unknown."""
        if self.margin is None:
            raise InputError(self.reason)
        return self.margin


def _is_quantity(load: Any) -> bool:
    """True for a number, or text such as "500 N", which is no path of a table."""
    with suppress(InputError):
        in_si("load", load, "500 N")
        return True
    return False


def asked_of(data: Results, points: OperatingPoints | None) -> Iterator[Asked]:
    """Judge operating points for each variant of a sweep; yield one `Asked` per point and variant.

    A variant is one combination of values of the varied entries. If `points` is None, each variant
    is judged at the load and velocity for which it was computed. An `InputError` is raised if these
    are not a single pair, as in a sweep with a grid of loads and velocities.
    """
    if points is not None:
        require_kind(data.kind, Layout.PLANE)
    for judge in map(judge_of, data.scenes):
        place = judge.source.place
        if points is None and place is None:
            raise InputError(
                "no operating point is given, and rows of the sweep have none; give a load and a "
                "velocity (--load and --velocity), or a table of them (--points)"
            )
        own_place = [(place, dict[str, float]())] if place else []
        yield from _asked(judge, [*(points.rows if points else own_place)])


def _asked(judge: Judge, points: Sequence[tuple[Place, Mapping[str, float]]]) -> list[Asked]:
    """Judge operating points (load, velocity) of one scene, each with its own conditions."""
    found, alike = dict[int, Asked](), dict[tuple[Any, ...], list[int]]()
    for number, (_, own) in enumerate(points):
        alike.setdefault((*own.items(),), []).append(number)
    judges, oil_names = dict[Any, Judge](), ("critical_temperature", "failing_share")
    for conditions, numbers in alike.items():
        here, own = [points[number][0] for number in numbers], dict(conditions)
        try:
            oil = {name: value for name, value in own.items() if name in oil_names}
            if (shared := (*oil.items(),)) not in judges:  # tests are compared once for each
                judges[shared] = judge.judged_by(oil)
            others = {name: value for name, value in own.items() if name not in oil_names}
            under = judges[shared].judged_by(others)
            met = [
                [snap(x, *under.rises.ends[name]) for name, x in zip(PLANE, place, strict=True)]
                for place in here
            ]
            margins = [
                margin
                for begin in range(0, len(met), _AT_ONCE)
                for margin in margins_at(under, *np.array(met[begin : begin + _AT_ONCE]).T)
            ]
        except InputError as error:
            margins = [str(error)] * len(here)
        for number, place, margin in zip(numbers, here, margins, strict=True):
            answer = (None, margin) if isinstance(margin, str) else (margin, "")
            found[number] = Asked(judge.source, place, own, *answer)
    return [found[number] for number in range(len(points))]


def margins_at(judge: Judge, loads: Array, velocities: Array) -> list[Margin | str]:
    """Margin at each of k pairs of load [N] and velocity [m/s], or why it is unknown."""
    found = judge.rises.known(loads, velocities)
    is_known = np.array([not reason for reason in found.reasons])
    if not is_known.any():
        return [*found.reasons]
    loads, velocities = loads[is_known], velocities[is_known]
    conditions = judge.conditions
    temperatures = conditions.contact_temperature(judge.rises.rise(loads, velocities))
    critical = known_critical_temperature(conditions)
    outside = judge.outside(loads, velocities)
    low, likely, high = np.where(outside, math.nan, judge.chances(loads, velocities))
    no_mild, no_severe, names = judge.forbidden(loads, velocities)
    parts = rise_errors(judge.rises, loads, velocities).T
    turns = judge.rises.turns("velocity", loads)
    critical_velocities, velocity_texts = turns_inside(judge.rises, "velocity", loads, turns)
    turns = judge.rises.turns("load", velocities)
    critical_loads, load_texts = turns_inside(judge.rises, "load", velocities, turns)
    is_passed = (turns.first < loads) & (temperatures <= critical)
    is_at_edge = judge.rises.have_warning(loads, velocities, WarningKind.CONTACT_AT_EDGE)
    notes, patches = scene_caveats(judge.source, conditions), int(counted(judge.source).sum())
    tested = np.full(len(loads), math.nan)
    if judge.evidence.results:
        likely_turns = judge.tested_velocities(loads)[1]
        tested = inside_alone(judge.rises, "velocity", loads, likely_turns)[0]
    why = forbidding_words(judge)
    margins = (
        Margin(
            load=float(loads[k]),
            velocity=float(velocities[k]),
            conditions=verdict_conditions(
                conditions, float(velocities[k]), judge.source.told_tests
            ),
            probability=float(likely[k]),
            lowest=float(low[k]),
            highest=float(high[k]),
            deciding_temperature=here,
            error=RiseError.of(parts[k]).times(conditions.temperature_error(here)),
            critical_temperature=critical,
            distance=critical - here,
            model_error=judge.evidence.text,
            critical_velocity=float(critical_velocities[k]),
            tested_velocity=float(tested[k]),
            critical_load=float(critical_loads[k]),
            velocity_outcome=velocity_texts[k],
            load_outcome=load_texts[k],
            is_outside=bool(outside[k]),
            is_computed=bool(found.is_computed[is_known][k]),
            is_continued=bool(found.is_continued[is_known][k]),
            patches=patches,
            not_mild=why[0] or f"{names[k]} forbids it" * bool(no_mild[k]),
            not_severe=why[1] or f"{names[k]} forbids it" * bool(no_severe[k]),
            tested=tuple(tests_beside(judge.evidence, loads[k], velocities[k])),
            caveats=(PASSED,) * bool(is_passed[k]) + (AT_EDGE,) * bool(is_at_edge[k]) + notes,
            entries={path: judge.source.rows[path].item() for path, _ in judge.source.name},
        )
        for k, here in enumerate(temperatures.tolist())
    )
    return [reason or next(margins) for reason in found.reasons]


def forbidding_words(judge: Judge) -> tuple[str, str]:
    """Why no place of a case is mild, and why none is severe; empty where tests allow it."""
    no_mild, no_severe = judge.evidence.open_sides
    why = waiting_words(judge.evidence)
    return why * no_mild, why * no_severe


def margin_frame(
    data: Results, found: Sequence[Asked], points: OperatingPoints | None = None
) -> pd.DataFrame:
    """Data frame with a row for each judged operating point in `found`.

    Varied entries, and further columns of the user's `points`, come first; a heading that the
    answers have gets the suffix "(given)".
    """
    names = list(data.entry_dims)
    if data.kind is Layout.PLACES:
        labels = [name for one in found[:1] for name in one.source.labels]
        names = [name for name in labels if name != VARIANT] or labels
    heads = heads_of(data.rows, names)
    columns: dict[str, list[Any]] = {
        head: [shown_label(data.rows[name], one.source.labels[name]) for one in found]
        for name, head in heads.items()
    }
    rows = []
    for one in found:
        notes = [*doubts_of_row(one.own)]
        if one.margin is None:
            values = ["not known", *[None] * (len(_COLUMNS) - 1)]
            notes.insert(0, one.reason)
        else:
            values = [getattr(one.margin, name) for name in _COLUMNS]
            film = OUTSIDE_WORDS * one.margin.is_outside
            notes += [*filter(None, [film, one.margin.against]), *one.margin.caveats]
        rows.append((*one.place, *values, join_notes(notes)))
    answers = frame_of(("load [N]", "velocity [m/s]", *_COLUMNS.values(), "notes"), rows)
    for head, given in points.others.items() if points else ():
        name = f"{head} (given)" if head in answers or head in columns else head
        columns[name] = [*given] * (len(answers) // len(given))  # points repeat for each scene
    return pd.concat([pd.DataFrame(columns, answers.index), answers], axis="columns")


_COLUMNS = column_heads(
    "verdict", "probability", "deciding_temperature", "temperature_error", "surface_error",
    "distance",
    "velocity_factor", "critical_velocity", "tested_velocity", "velocity_outcome",
    "load_factor", "critical_load", "load_outcome", "conditions",
) | {"tested_velocity": "with tests [m/s]"}  # fmt: skip
"""Column headings by the name of the attribute of `Margin`."""
LONG = (
    "temperature error [K]", "surface error [K]", "critical velocity [m/s]", "with tests [m/s]",
    "critical load [N]", "velocity outcome", "load outcome", "conditions", "notes",
)  # fmt: skip
"""Columns left out on a terminal or a page, which are too narrow."""


def counts_in_words(frame: pd.DataFrame, points: OperatingPoints | None = None) -> str:
    """Numbers of operating points by verdict, in words; with their hours if `points` has them."""
    hours = _hours(points) if points and len(points.places) == len(frame) else None
    said = list[str]()
    for verdict, number in sorted(Counter(frame["verdict"]).items()):
        own = "" if hours is None else f" ({hours[frame['verdict'] == verdict].sum():.4g} h)"
        said.append(f"{number} {verdict}{own}")
    return ", ".join(said)


def _hours(points: OperatingPoints) -> Array | None:
    """Hours of each operating point, from the only column of a duration; None without one."""
    found = list[Array]()
    for head, cells in points.others.items():
        unit = Column.of(head, ()).unit
        if unit in ("s", "min", "h"):
            with suppress(ValueError):
                one = to_si(f"1 {unit}", "1 h") / 3600
                found.append(one * np.array([*map(float, cells)]))
    return found[0] if len(found) == 1 else None
