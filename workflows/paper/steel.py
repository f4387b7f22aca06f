"""Conductivity of the steel, from the measured transitions of both oils."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline
from scipy.special import logsumexp

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, in_house_style
from pipeline.run.vary import vary
from tribo.types import Array
from workflows.paper.eight import (
    SURFACES,
    Physics,
    Transitions,
    log_evidence,
    rounded,
    transitions_of,
)
from workflows.paper.report import Report, Table, line
from workflows.paper.study import Study

_NODES = (15.0, 21.0, 27.0, 33.0, 39.0, 45.0, 51.0, 60.0, 70.0)  # W/(m K)
_FINE = np.linspace(_NODES[0], _NODES[-1], 221)
_SOFT, _HARD = 45.0, 21.0  # of the paper's table, and measured of the through-hardened steel
_SETS = {
    "white oil alone": ("white oil",),
    "oil A alone": ("oil A",),
    "both oils": ("white oil", "oil A"),
}
_LOOKS = dict(zip(_SETS, (BLUE, VERMILION, BLACK), strict=True))
_STEADY = 0.2  # of the conductivity that was taken, which the transitions have to allow


def steel(study: Study) -> Report:
    """Conductivity against critical temperature, by white oil, oil A and both."""
    transitions = transitions_of(study, ("swept",), _NODES)
    warmings = np.array([Physics(K).warming(transitions) for K in _NODES])
    fine = CubicSpline(_NODES, warmings)(_FINE)
    posteriors = {name: _posterior(transitions, fine, oils) for name, oils in _SETS.items()}
    boundary, bulks = _boundary(study), transitions.bulk_celsius
    named = [
        f"{oil}, {load:g} N, {bulk:g} °C"
        for oil, load, bulk in zip(transitions.oil, transitions.load, bulks, strict=True)
    ]
    critical = {K: bulks + np.exp(row) for K, row in zip(_NODES, warmings, strict=True)}
    both = posteriors["both oils"]
    values: dict[str, Any] = {
        "soft": _SOFT,
        "hard": _HARD,
        "surfaces": len(study.seeds(SURFACES)),
        **{f"{name.split()[0]}_{key}": its[key] for name, its in posteriors.items() for key in its},
        "changes": boundary["change"],
    }
    return Report.of(
        "steel",
        values,
        verdicts={
            "conductivity": abs(both["mean"] / _SOFT - 1) < _STEADY,
            "hardened": both["odds"] < 1,
        },
        table=Table(
            ("", f"K {_SOFT:g} W/(m K)", f"K {_HARD:g} W/(m K)"),
            (
                ("critical velocity at friction 0.1 [m/s]",),
                *(
                    line(f"  {load:g} N", pair, ".2f")
                    for load, *pair in zip(
                        boundary["load"], boundary["soft"], boundary["hard"], strict=True
                    )
                ),
                ("critical temperature from each transition [°C]",),
                *(
                    line(f"  {name}", pair)
                    for name, *pair in zip(named, critical[_SOFT], critical[_HARD], strict=True)
                ),
            ),
        ),
        data={
            "critical_celsius_by_conductivity": {f"{K:g}": row for K, row in critical.items()},
            "conductivity": posteriors,
            "boundary": boundary,
        },
        figure=_draw(transitions, fine, posteriors),
    )


def _posterior(transitions: Transitions, warmings: Array, oils: Sequence[str]) -> dict[str, Any]:
    """Conductivity by the transitions of some oils, evenly likely before."""
    log, critical = log_evidence(transitions, warmings, oils=oils)
    probability = np.exp(log - logsumexp(log))
    mean = float(probability @ _FINE)
    below = np.cumsum(probability)
    low, high = (float(np.interp(level, below, _FINE)) for level in (0.05, 0.95))
    odds = np.exp(np.interp(_SOFT, _FINE, log) - np.interp(_HARD, _FINE, log))
    return {
        "mean": mean,
        "sd": float(np.sqrt(probability @ (_FINE - mean) ** 2)),
        "low": low,
        "high": high,
        "odds": float(1 / odds),
        "times": rounded(float(odds)),
        "density": (probability / (_FINE[1] - _FINE[0])).tolist(),
        "critical": critical[oils[0]].tolist(),
    }


def _boundary(study: Study) -> dict[str, Any]:
    """Critical velocities with both conductivities, at friction 0.1."""
    changes: Mapping[str, Any] = {
        "sweep.loads": ["200 N", "400 N", "600 N", "750 N"],
        "sweep.velocities": {"from": "0.2 m/s", "to": "5 m/s", "step": "0.2 m/s"},
    }
    entry = "materials.steel.thermal_conductivity"
    scene = Path(study.scenes, "irg_transition.toml")
    variation = vary(scene, {entry: [f"{_HARD:g} W/(m K)"]}, study.preset, changes, tell=study.tell)
    (hard,) = variation.others
    return {
        "load": list(variation.loads)[::-1],
        "soft": list(variation.base.critical_velocities)[::-1],
        "hard": list(hard.critical_velocities)[::-1],
        "change": variation.changes(hard).tolist()[::-1],
    }


@in_house_style
def _draw(transitions: Transitions, warmings: Array, posteriors: Mapping[str, Any]) -> Figure:
    figure = Figure(figsize=(7.0, 3.4))
    left, right = figure.subplots(1, 2)
    labelled = set()
    for oil, bulk, row in zip(transitions.oil, transitions.bulk_celsius, warmings.T, strict=True):
        label = f"{oil}, bulk {bulk:.0f} °C"
        left.plot(
            _FINE, bulk + np.exp(row), color=BLUE if oil == "white oil" else VERMILION,
            ls="-" if bulk < 50 else "--", label=None if label in labelled else label, lw=1.2,
        )  # fmt: skip
        labelled.add(label)
    left.axhspan(137, 153, color=GREEN, alpha=0.2, lw=0, label="white oil on the rig, 145 ± 8 °C")
    left.set(xlabel="conductivity of the steel [W/(m K)]", ylabel="critical temperature [°C]")
    left.set_title("from each measured transition", loc="left")
    for name, posterior in posteriors.items():
        right.plot(_FINE, posterior["density"], color=_LOOKS[name], label=name)
    for K, label in ((_SOFT, "taken, as annealed"), (_HARD, "measured, hardened")):
        right.axvline(K, color=GREY, ls=":", lw=1.2)
        right.annotate(
            label, (K, 1.0), (3, -3), xycoords=("data", "axes fraction"), va="top", fontsize=8,
            textcoords="offset points", color=GREY, rotation=90,
        )  # fmt: skip
    right.set_ylim(0, 1.4 * right.get_ylim()[1])  # room for the names of both
    right.set(xlabel="conductivity of the steel [W/(m K)]", ylabel="probability per W/(m K)")
    right.set_title("what the transitions say", loc="left")
    for axes in (left, right):
        axes.legend(loc="upper right", fontsize=7.5)
    return figure
