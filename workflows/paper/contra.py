"""The next experiment: load × velocityⁿ at scuffing of a ball and a disk that contra-rotate."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.figures.style import BLACK, BLUE, house_style
from tribo import simulate
from tribo.simulation import state_rises
from tribo.types import Array

from .publication import TABLE_4
from .recomputed import Recomputation, texts
from .smooth import load_speed_exponent
from .study import Study

_SCENE = "mtm"
_LOADS = (20.0, 40.0, 75.0)  # N
_VELOCITIES = (1.5, 2.5, 4.0)  # m/s, of sliding
_SURFACES = 2
_RATIO = 20.0  # slide-roll ratio: sliding is twenty times entrainment
_CONSTANT = 0.05  # largest misfit of ln(rise) at which F·Vⁿ counts as constant
_USUAL = "as predicted"
_CHANGES: Mapping[str, Mapping[str, Any]] = {
    _USUAL: {},
    "slide-roll ratio 5": {"motion.slide_roll_ratio": 5.0},
    "no wear": {"wear": None},
    "ten times the wear rate": {"wear.specific_wear_rate": "1.2e-5 mm^3/(N m)"},
    "Ra 0.05 µm": {"disk.roughness.ra": "0.05 um"},
    "correlation length 8 µm": {"disk.roughness.correlation_length": "8 um"},
    "preset fine": {"fidelity.preset": "fine"},
}


def contra(study: Study) -> Recomputation:
    """Report on the exponent n of load × velocityⁿ that the model predicts, and on its error."""
    seeds = study.seeds(_SURFACES)
    few = seeds[:1]
    exponents: dict[str, list[float]] = {}
    misfits: dict[str, float] = {}
    for name in study.stages(_CHANGES):
        entries = {"motion.slide_roll_ratio": _RATIO, **_CHANGES[name]}
        scene = _changed(study.scene(_SCENE), entries)
        fits = [_fit(scene.take_surface(seed)) for seed in (seeds if name == _USUAL else few)]
        exponents[name] = [n for n, _ in fits]
        misfits[name] = max(misfit for _, misfit in fits)
    usual = np.array(exponents[_USUAL])
    choices = {name: its[0] - usual[0] for name, its in exponents.items() if name != _USUAL}
    # Independent parts: surfaces as twice their standard deviation, and each choice.
    parts = [2 * usual.std(ddof=1) if len(usual) > 1 else 0.0, *choices.values()]
    error = math.sqrt(sum(part**2 for part in parts))
    measured = load_speed_exponent(TABLE_4.normal_load.tolist(), TABLE_4.velocity.tolist())
    values = {
        "n": float(usual.mean()),
        "error": error,
        "ratio": _RATIO,
        "surfaces": len(usual),
        "misfit": misfits[_USUAL],
        "largest": max(choices, key=lambda name: abs(choices[name])),
        "measured": measured,
        "ends": (min(_LOADS), max(_LOADS), min(_VELOCITIES), max(_VELOCITIES)),
    }
    return Recomputation.from_values(
        "contra",
        values,
        verdicts={"exponent": misfits[_USUAL] < _CONSTANT},
        table=texts(
            ("", "n", "change"),
            [
                (name, f"{np.mean(its):.2f}", f"{choices[name]:+.2f}" if name in choices else "")
                for name, its in exponents.items()
            ],
        ),
        data={"exponents": exponents, "misfits": misfits, "error": error},
        figure=_draw(float(usual.mean()), error, exponents),
    )


def _changed(sweep: Sweep, entries: Mapping[str, Any]) -> Sweep:
    for path, entry in entries.items():
        sweep = sweep.changed(path, entry)
    return sweep


def _fit(sweep: Sweep) -> tuple[float, float]:
    """Exponent n for which the governing rise depends on F·Vⁿ, and the largest misfit of ln(rise).

    The rise is fitted by C·Fᵃ·Vᵇ, so that n = b/a wherever the boundary lies.
    """
    points = list(itertools.product(_LOADS, _VELOCITIES))
    logs = np.log([_rise(sweep, *point) for point in points])
    terms = np.column_stack([np.ones(len(points)), np.log(points)])
    law, *_ = np.linalg.lstsq(terms, logs, rcond=None)
    return float(law[2] / law[1]), float(np.abs(logs - terms @ law).max())


def _rise(sweep: Sweep, load: float, velocity: float) -> float:
    """Governing rise at friction 1 [K] at the end of a ramp to a load, at a velocity."""
    *_, state = simulate(sweep.scene, load, velocity)
    rises = state_rises(sweep.scene, state, sweep.conditions.corrections)
    return float(sweep.conditions.governing_rise(rises))


@house_style
def _draw(n: float, error: float, exponents: Mapping[str, Any]) -> Figure:
    figure = Figure(figsize=(7.4, 4.0))
    axes = figure.subplots()
    names = list(exponents)[::-1]
    for row, name in enumerate(names):
        values: Array = np.asarray(exponents[name])
        colour = BLUE if name == _USUAL else BLACK
        axes.plot(values, np.full(len(values), row), "o", color=colour, ms=6)
    axes.axvspan(n - error, n + error, color="#E6E6E6", zorder=0)
    axes.axvline(n, color=BLUE, lw=1.2)
    axes.set_yticks(range(len(names)), names)
    axes.set(ylim=(-0.6, len(names) - 0.4), xlabel="n of load × velocityⁿ = constant")
    axes.set_title("n by the model, with its error (grey); dots: surfaces", loc="left")
    return figure
