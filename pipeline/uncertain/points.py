"""Probability of severe wear at many operating points, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.analysis.margin_table import table_of_points
from pipeline.analysis.operating_points import OperatingPoints
from pipeline.analysis.tables import Column, Table
from pipeline.store.place import PathLike
from pipeline.uncertain.answers import QUANTILES, Interval, draws_of, risk, temperatures
from pipeline.uncertain.ensemble import Ensemble, Overrides
from pipeline.uncertain.inputs import Draws


def risk_table(
    ensemble: Ensemble,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]],
    draws: Draws | None = None,
    conditions: Overrides = None,
) -> Table:
    """Table of the probability of severe wear at operating points, and of their distance from it.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    points : path or mapping of str to sequence
        Operating points; see `pipeline.margin_table`.
    draws, conditions : optional
        See `pipeline.risk`.

    Returns
    -------
    Table
        A row for each operating point: mild or severe where 95 % of the probability says so, the
        probability, and the distance to the critical temperature with 5, 50 and 95 % of it below.
        A point that the samples say nothing about has a note instead.

    Raises
    ------
    InputError
        If the table has faults, all of which are named, or the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> points = {"load": ["400 N", "400 N"], "velocity": ["1 m/s", "2.2 m/s"]}
    >>> pipeline.risk_table(ensemble, points).as_dict()["verdict"]
    ['mild', 'uncertain']
    """
    read = points if isinstance(points, OperatingPoints) else OperatingPoints.read(points)
    drawn = draws_of(ensemble, draws)

    def answer(load: float, velocity: float) -> tuple[Any, ...]:
        here = risk(ensemble, load, velocity, drawn, conditions)
        temperature, critical = temperatures(ensemble, drawn.inputs, load, velocity, conditions)
        distance = Interval.of(drawn, critical - temperature)
        (least, _, most), chance = QUANTILES, here.probability
        verdict = "mild" if chance <= least else "severe" if chance >= most else "uncertain"
        ends = distance.middle, distance.low, distance.high
        return verdict, chance, here.error, *ends, None

    return table_of_points(read, _COLUMNS, answer)


_COLUMNS = (
    Column("verdict", "verdict"),
    Column("probability", "probability of severe wear", write="{:.3f}".format),
    Column("error", "standard error", write="{:.3f}".format),
    Column("distance", "below the critical", "K", 3),
    Column("distance_low", f"below it, {100 * QUANTILES[0]:g} %", "K", 3),
    Column("distance_high", f"below it, {100 * QUANTILES[-1]:g} %", "K", 3),
)
