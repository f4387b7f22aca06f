"""The contact while the load grows: a picture for each load, written as an animated one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.animation import PillowWriter
from matplotlib.figure import Figure

from pipeline.analysis.conditions import Bulk, conditions_of
from pipeline.figures.fields import contact, has_fields, require_fields, scales, shown, with_fields
from pipeline.figures.points import chosen_points
from pipeline.store.schema import DONE
from tribo import InputError

_PACE = 2  # pictures a second
_LAST = 3  # times that the last picture is shown again
_DPI = 100


def animation(
    ds: xr.Dataset,
    load: float | str | None = None,
    velocity: float | str | None = None,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    realization: int | None = None,
    stacked: bool = False,
) -> list[Figure]:
    """Draw the contact at the end of each load up to one, on the same scales.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    load : float or str, optional
        Load up to which to draw [N], or text with a unit; the highest if not given.
    velocity : float or str, optional
        Velocity of the points [m/s], or text with a unit; the one nearest to the transition at
        that load if not given.
    friction, bulk_temperature, critical_temperature, share, criterion
        See `pipeline.boundary`.
    realization : int, optional
        Seed of the surface to draw; the first if not given.
    stacked : bool
        Panels below each other, not side by side.

    Returns
    -------
    list of Figure
        A figure for each load whose point is done and has fields, ascending.

    Raises
    ------
    InputError
        If the sweep holds no fields, or was run without them at the last point.
    """
    conditions = conditions_of(
        ds, friction, bulk_temperature, critical_temperature, share, criterion
    )
    ds = with_fields(ds, conditions, realization)
    last, index = chosen_points(ds, load, velocity, conditions)[0]
    require_fields(ds, (last, index))
    done = np.flatnonzero(
        ds["status"].transpose("load", "velocity").values[: last + 1, index] == DONE
    )
    points = [(int(i), index) for i in done if has_fields(ds, (int(i), index))]
    limits = np.array([scales(shown(ds, point, conditions)) for point in points])
    ends = np.stack([limits[:, :, 0].min(axis=0), limits[:, :, 1].max(axis=0)], axis=1)
    return [contact(ds, point, conditions, stacked, ends) for point in points]


def save_animation(figures: Sequence[Figure], out: Path, dpi: float | None = None) -> Path:
    """Write figures of one size as an animated GIF.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    for figure in figures:  # places settle as they are drawn, and are to stay from then on
        figure.draw_without_rendering()
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
    writer = PillowWriter(fps=_PACE)
    try:
        with writer.saving(figures[0], str(out), _DPI if dpi is None else dpi):
            for figure in [*figures, *[figures[-1]] * _LAST]:
                writer.fig = figure
                writer.grab_frame()
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror or error}") from error
    return out
