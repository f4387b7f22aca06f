"""Points of a sweep that carry a warning.

Most warnings are stored by the run. Two are found here: steel would melt under the conditions, and
the rise grows slowly with velocity. The relative error of a critical velocity is that of the rise
over the exponent n of rise ∝ Vⁿ. Below n = 0.3 this error was 5 to 8 % with preset `standard`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from pipeline.analysis.dataset import Layout
from pipeline.analysis.reading import ResultsLike, results
from pipeline.analysis.results import Results
from pipeline.analysis.scenes import value_text
from pipeline.constants import APART_FOR_EXPONENT
from pipeline.quantities import display
from pipeline.sweep.conditions import Conditions
from pipeline.words import remarks
from tribo import CRITERIA, Criterion, WarningKind
from tribo.constants import SLOWEST
from tribo.simulation.point_warnings import SLOW
from tribo.types import Array, Indices, Mask

MELTS = 1700.0  # K, at which a steel with 1 % carbon begins to melt
MOLTEN = (
    f"the deciding temperature is above {display(MELTS, '°C', '.0f')}, where steel melts: the "
    "bodies of the model do not melt, so it says only that wear is severe; if tests were made "
    "here, check load, velocity and units"
)


@dataclass(frozen=True, slots=True)
class Warned:
    """Counts of points that carry a warning, by kind."""

    points: int = 0  #: Points with at least one warning.
    #: Number of points by the kind of warning.
    kinds: Mapping[str, int] = field(default_factory=dict)
    example: str = ""  #: The first of these points, with its warning.

    def lines(self) -> Iterator[str]:
        """Yield two lines: how many points carry each kind of warning, and the first such point.

        If no point carries a warning, nothing is yielded.
        """
        if not self.points:
            return
        kinds = ", ".join(f"{kind}: {count}" for kind, count in self.kinds.items())
        carry = "1 point carries" if self.points == 1 else f"{self.points} points carry"
        yield from remarks("warning", f"{carry} a warning ({kinds})", f"at {self.example}")


@np.errstate(under="ignore")
def warned(ds: ResultsLike) -> Warned:
    """Count the points of a sweep that carry a warning, such as too few elements in contact.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or the path of a store.

    Returns
    -------
    Warned
        Number of points with a warning, in total and by the kind of warning, and an example. One
        kind, "molten", says that steel would melt. With several values of a condition, such as two
        frictions, this kind counts points where steel would melt at one of these values.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.warned(pipeline.open_sweep("results/first_try.zarr")).points
    0
    """
    data = results(ds)
    judged = tuple(data.front.index(name) for name in data.judged_dims)
    flags = warning_flags(data) | _mask_by_scene(data, _is_molten) * int(WarningKind.MOLTEN)
    flags = np.bitwise_or.reduce(flags, axis=judged)
    counts = {kind.label: int((flags & kind != 0).sum()) for kind in WarningKind}
    return Warned(
        points=int((flags != 0).sum()),
        kinds={kind: count for kind, count in counts.items() if count},
        example=_example(data.take(dict.fromkeys(data.judged_dims, 0)), flags),
    )


def warning_flags(data: Results) -> Indices:
    """Sum of `WarningKind` codes of each point: the stored ones, and ``SLOW_RISE``.

    ``SLOW_RISE`` is found here from neighbouring points: the rise hardly grows with velocity. The
    sum is 0 at a point that is not done.
    """
    data.require("status", "warning_flags")
    flags = np.where(data.done, data.columns["warning_flags"], 0).astype(int)
    return np.asarray(flags | _mask_by_scene(data, _rises_slowly) * int(WarningKind.SLOW_RISE))


def _is_molten(scene: Results) -> Mask:
    """Mask of points where steel would melt in more of the contact than the criterion's share."""
    # The user's own criterion is not run here; "share" serves as well.
    judged = scene.plain_conditions
    return np.asarray(scene.rises(judged) > judged.limit(MELTS))


def _mask_by_scene(data: Results, mark: Callable[[Results], Mask]) -> Mask:
    """Mask of all points, joined from those that `mark` returns by scene; False off a grid."""
    if data.kind is not Layout.PLANE:
        return np.zeros(data.done.shape, bool)
    return np.reshape([mark(scene) for scene in data.scenes], data.done.shape)


def _example(data: Results, flags: Indices) -> str:
    """The first point that carries a warning (`flags` not 0), with its message; else empty."""
    if not flags.any():
        return ""
    *row, load, velocity = np.argwhere(flags)[0].tolist()
    here = data.take(dict(zip(data.front, row, strict=True)))
    flag = flags[(*row, load, velocity)]
    texts = {WarningKind.SLOW_RISE: SLOW, WarningKind.MOLTEN: MOLTEN}
    said = [here.messages[load, velocity], *(texts[kind] for kind in texts if flag & kind)]
    # Shown if there is no message, as in a dataset that was copied without its store.
    kinds = ", ".join(kind.label for kind in WarningKind if flag & kind)
    values = tuple((n, value_text(here.rows[n], here.rows[n].item())) for n in data.front)
    point = here.point(load, velocity)._replace(variant=values)
    return f"{point}: {'; '.join(filter(None, said)) or kinds}"


def _rises_slowly(scene: Results) -> Mask:
    """Mask of points where d ln(rise)/d ln(velocity), for equal bulks, is below `SLOWEST`."""
    stored = scene.sweep.conditions.criterion
    kind = stored.name if stored.name in CRITERIA else "share"
    plain = Conditions(1.0, 300.0, criterion=Criterion(kind, stored.share))
    rises, x = scene.rises(plain), scene.velocities
    return np.apply_along_axis(lambda row: exponents(x, row) < SLOWEST, -1, rises)


def exponents(x: Array, y: Array) -> Array:
    """Exponent d ln(y)/d ln(x) at each point of a curve y(x), from neighbours around it.

    It is NaN if no neighbours are far enough apart.
    """
    result = np.full(x.shape, math.nan)
    (known,) = np.nonzero((x > 0) & np.isfinite(y) & (y > 0))
    log_x, log_y = np.log(x[known]), np.log(y[known])
    least = math.log(APART_FOR_EXPONENT)
    low = np.maximum(np.searchsorted(log_x, log_x - least, "right") - 1, 0)
    high = np.minimum(np.searchsorted(log_x, log_x + least), len(known) - 1)
    ways = log_x[high] - log_x[low]
    is_apart = ways >= least
    result[known[is_apart]] = (log_y[high] - log_y[low])[is_apart] / ways[is_apart]
    return result
