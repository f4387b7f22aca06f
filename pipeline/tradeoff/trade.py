"""Processor time against the whole error of a scene's boundary, for each accuracy that one may ask.

The first patch's boundary is searched with the fastest preset. From there searches with smaller
errors are rehearsed on the interpolated rises, with patches that differ as the jackknife says. A
timed point of each preset gives the cost. `irg trade` prints and draws the curve.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from pipeline.analysis.preset_error import velocity_error
from pipeline.analysis.reached import percent
from pipeline.analysis.rise_error import INTERPOLATION, PRESET, SURFACE, WARNED, totals
from pipeline.analysis.specimen import Alone
from pipeline.analysis.tables import frame_of, lines_of, short
from pipeline.constants import GOALS
from pipeline.progress import Progress, Report, silent
from pipeline.run.goal import require_boundary, why_fixed
from pipeline.run.goal_preset import choose_preset, goal_presets, seconds_of_point
from pipeline.run.search import MOST_PATCHES, Goal
from pipeline.scene.read import SceneLike, sweep_of
from pipeline.sweep.sweep import Sweep
from pipeline.tradeoff.forecast import Estimate, estimate
from pipeline.tradeoff.rehearsal import FirstPatch, Rehearsed
from tribo.types import Indices

_GRIDS = (3, 4), (4, 6), (6, 10), (9, 14)  # loads and velocities
_SECONDS_TO_START = 2.5  # of processor time, for workers
_SECONDS_OF_A_POINT = 0.05  # to hand it to a worker, make its surface, and write it
_HEADS = (
    "run", "preset", "points", "patches", "CPU time [s]", "error [%]", "surface [%]",
    "left out [%]", "by preset [%]", "warned [%]", "command",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Choice:
    """What a run would compute, its cost, and the error of the boundary that it would reach."""

    accuracy: float | None  #: Error that is asked for; None for a uniform plane.
    shape: tuple[int, int]  #: Loads and velocities of the plane.
    preset: str | None  #: None for numerical choices of one's own.
    points: int
    patches: int
    seconds: float  #: Processor time [s].
    #: Bounds of the relative error at 95 % by cause, at the load where the whole is largest: points
    #: left out, preset, warned points, surface; NaN if unknown.
    errors: tuple[float, float, float, float]

    @property
    def error(self) -> float:
        """The whole relative error; NaN if a part is unknown."""
        return math.hypot(*self.errors)


@dataclass(frozen=True, slots=True)
class Trade:
    """Processor time and error of the boundary of a scene, by the accuracy that is asked for."""

    drawn_by: ClassVar = "pipeline.figures.studies:draw_trade"
    title: str  #: Title of the scene.
    scene: str  #: The scene, and the options that change it, as typed in a command.
    searches: tuple[Choice, ...]  #: Runs with an accuracy, from the largest error to the smallest.
    planes: tuple[Choice, ...]  #: Uniform planes; the last is the scene's own.
    notes: tuple[str, ...]  #: What limits the errors.

    @property
    def advised(self) -> Choice:
        """The run whose squared error times processor time is least; without any, the plane.

        By patches alone half the error takes four times the points. Beyond this run it takes more.
        """
        return min(
            self.searches,
            key=lambda one: (one.accuracy or 0.0) ** 2 * one.seconds,
            default=self.planes[-1],
        )

    def command(self, choice: Choice) -> str:
        """Command that computes a choice; empty for a plane that is not the scene's."""
        if choice.accuracy is not None:
            return f"irg run {self.scene} --accuracy {100 * choice.accuracy:g}%"
        return f"irg run {self.scene}" if choice is self.planes[-1] else ""

    @property
    def table(self) -> pd.DataFrame:
        """Frame with a row for each choice: searches first, then uniform planes.

        Errors [%] are bounds at 95 %, at the load where the whole error is largest.
        """
        return short(frame_of(_HEADS, map(self._row, (*self.searches, *self.planes))))

    def _row(self, choice: Choice) -> tuple[object, ...]:
        run = "plane {} × {}".format(*choice.shape)
        if choice.accuracy is not None:
            run = f"accuracy {100 * choice.accuracy:g}%"
        errors = [choice.errors[part] for part in (SURFACE, INTERPOLATION, PRESET, WARNED)]
        errors[-1] = errors[-1] or math.nan  # a column for warnings only if there are some
        return (
            run,
            choice.preset or "own",
            choice.points,
            choice.patches,
            float(f"{choice.seconds:.2g}"),
            *(float(f"{error:.3g}") for error in (choice.error, *errors)),
            self.command(choice),
        )

    def __str__(self) -> str:
        return "\n".join(
            [
                f"{self.title}: processor time against the error of the boundary",
                "",
                *lines_of(self.table.drop(columns="command")),
                "",
                "Errors are bounds at 95 %, at the load where they are largest: by the choice of",
                "patches of the surface, points left out, and the preset. Times are right within a",
                "factor of two.",
                *self.notes,
                f"advised: {self.command(self.advised)}",
            ]
        )


@np.errstate(under="ignore")
def trade(scene: SceneLike, progress: Report | None = None) -> Trade:
    """Estimate what each accuracy of a scene's boundary costs, and what uniform planes reach.

    The first patch of the scene is searched, a point of each preset is timed, and from there on
    runs with an accuracy are rehearsed. Of several scenes in a sweep, the first one is taken for
    all.

    Parameters
    ----------
    scene : Sweep, str or path
        Scene, or its path or name.
    progress : callable, optional
        Called with a `Progress` at each stage.

    Raises
    ------
    InputError
        If the sweep has no boundary.
    TriboError
        If a point has no solution.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.trade("first_try")
    >>> found.planes[-1].points, found.command(found.searches[0])
    (24, 'irg run first_try --accuracy 10%')
    """
    sweep, report = sweep_of(scene), progress or silent
    typed = os.fspath(scene) if isinstance(scene, str | os.PathLike) else sweep.name
    require_boundary(sweep)
    runs = _Runs.of(sweep, report)
    report(Progress("runs with each accuracy"))
    searches = tuple(runs.searches())
    return Trade(sweep.title, typed, searches, tuple(runs.planes()), tuple(runs.notes(searches)))


@dataclass(frozen=True, eq=False)
class _Runs:
    """Runs of a sweep, rehearsed on its first patch."""

    sweep: Sweep
    presets: tuple[Sweep, ...]  # that a run with an accuracy may take
    seconds: dict[str | None, float]  # processor time of the same point, by preset
    choosing: float  # processor time to find how heat must act [s]
    timing: float  # further time of a run that times points to choose its preset [s]
    first: FirstPatch
    plane: Estimate  # of all points on one patch

    @classmethod
    def of(cls, sweep: Sweep, report: Report) -> _Runs:
        began = time.process_time()
        report(Progress("how heat must act"))
        presets, seconds = goal_presets(sweep), dict[str | None, float]()
        choosing = time.process_time() - began
        for one in presets:
            report(Progress(f"a timed point of preset {one.preset}"))
            seconds[one.preset] = seconds_of_point(one)
        timing = time.process_time() - began - choosing
        report(Progress(f"boundary of the first patch by preset {presets[0].preset}"))
        first = FirstPatch.of(presets[0], report)
        alone = sweep if why_fixed(sweep) else sweep._with_patches(1)
        whole = estimate(alone, workers=1)
        return cls(sweep, presets, seconds, choosing, timing, first, whole)

    @property
    def _patches(self) -> int:
        """Number of patches of a plane."""
        seeds = self.sweep.variants.axes.get("realization", (0,))
        return len(seeds) if why_fixed(self.sweep) else 1

    def searches(self) -> Iterator[Choice]:
        """Runs with an accuracy that can be reached."""
        grows, least = not why_fixed(self.sweep), min(map(_promised, self.presets))
        most = MOST_PATCHES if grows else self._patches
        timed = set[str | None]()

        def seconds_of(one: Sweep) -> float:
            timed.add(one.preset)
            return self.seconds[one.preset]

        for accuracy in (one for one in GOALS if one > least):
            timed.clear()  # nothing is timed where a slower preset cannot pay
            chosen = choose_preset(self.presets, accuracy, seconds_of)
            goal = Goal(accuracy, _promised(chosen), most, grows, Alone.of(chosen.scene))
            found = self.first.rehearse(goal)
            aimed = np.where(np.arange(len(found.errors)) == SURFACE, grows, 1) * found.errors
            if totals(aimed) <= accuracy:
                seconds = self._seconds(found, chosen) + (self.timing if timed else 0.0)
                yield self._choice(found, chosen.preset, seconds, accuracy)

    def planes(self) -> Iterator[Choice]:
        """Uniform planes of the scene's own numerical choices, the scene's own plane last."""
        whole = self.first.rises.shape
        error = velocity_error(self.sweep)
        promised, alone = math.nan if error is None else error, Alone.of(self.sweep.scene)
        goal = Goal(1.0, promised, self._patches, alone=alone)
        smaller = [one for one in _GRIDS if one[0] < whole[0] and one[1] < whole[1]]
        for shape in (*smaller, whole):
            rows, columns = map(_spread, whole, shape)
            found = self.first.plane(rows, columns, goal)
            share = math.prod(shape) / math.prod(whole)
            seconds = _SECONDS_TO_START + share * self.plane.seconds
            yield self._choice(found, self.sweep.preset, seconds)

    def notes(self, searches: Sequence[Choice]) -> Iterator[str]:
        """What limits the errors, in sentences."""
        if not searches:
            yield f"No accuracy of {percent(max(GOALS))} or less is within reach."
        if velocity_error(self.sweep) is None:
            yield "The scene has own numerical choices, whose error is not known."
        if fixed := why_fixed(self.sweep):
            surface = max((one.errors[SURFACE] for one in searches), default=math.nan)
            yield f"surface ± {percent(surface)}: {fixed}"
        if (count := len(self.sweep._given)) > 1:
            yield f"The sweep has {count} scenes; each is taken to cost as much as the first."

    def _seconds(self, found: Rehearsed, chosen: Sweep) -> float:
        """Processor time of a run with an accuracy [s]."""
        ratio = self.seconds[chosen.preset] / self.seconds[self.presets[0].preset]
        times = ratio * self.first.seconds + _SECONDS_OF_A_POINT
        own = self.plane.tests
        points = len(self.sweep._given) * found.points @ times + own * times[-1]
        return float(_SECONDS_TO_START + self.choosing + points)

    def _choice(
        self, found: Rehearsed, preset: str | None, seconds: float, accuracy: float | None = None
    ) -> Choice:
        points = len(self.sweep._given) * int(found.points.sum())
        errors = tuple(found.errors.tolist())
        return Choice(accuracy, found.shape, preset, points, found.patches, seconds, errors)


def _promised(sweep: Sweep) -> float:
    return velocity_error(sweep) or 0.0


def _spread(count: int, wanted: int) -> Indices:
    """Indices of some of `count` values, the first and the last among them."""
    return np.linspace(0, count - 1, wanted).round().astype(int)
