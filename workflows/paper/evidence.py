"""Support of eight measured transitions for the assumptions of the physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import BLUE, GREY, VERMILION, in_house_style
from tribo.types import Array
from workflows.paper.eight import (
    SURFACES,
    Physics,
    Transitions,
    log_evidence,
    rounded,
    transitions_of,
)
from workflows.paper.report import Report, Table, cells
from workflows.paper.study import Study

_MODELS = {
    "as taken": Physics(),
    "K 21 for 45 W/(m K)": Physics(conductivity=21.0),
    "mean of the contact for 10 %": Physics(criterion="mean"),
    "highest for 10 %": Physics(criterion="highest"),
    "local for swept wear": Physics(pattern="local"),
    "with stem and track": Physics(holds_heat=True),
    "with an oil film's share": Physics(film=True),
}
_SHORT = ("taken", "K 21", "mean", "highest", "local", "stem", "film")
_STRONG, _WEAK = math.log(10), math.log(3)  # of odds, after Jeffreys
_DATA = 200  # simulated sets of transitions by each model
_SCATTER = 0.05  # of the rise, in them
_CRITICAL = {"white oil": (145.0, 8.0), "oil A": (260.0, 20.0)}  # °C and K, in them
_SHARE = 0.25  # of the load on the film over the film parameter, in them


def evidence(study: Study) -> Report:
    """Odds of other physics against what the scenes take, and each model on its own data."""
    transitions = transitions_of(study, ("swept", "local"), (45.0, 21.0))
    warmings = np.array([model.warming(transitions) for model in _MODELS.values()])
    weighed = [
        log_evidence(transitions, warming, model.film)
        for warming, model in zip(warmings, _MODELS.values(), strict=True)
    ]
    odds = [float(log - weighed[0][0]) for log, _ in weighed]
    critical = [[float(celsius[oil]) for oil in ("white oil", "oil A")] for _, celsius in weighed]
    confused = _confusions(transitions, warmings)
    names = list(_MODELS)
    values: dict[str, Any] = {
        "surfaces": len(study.seeds(SURFACES)),
        "number": len(transitions.oil),
        "sets": _DATA,
        "scatter": _SCATTER,
        **{short.replace(" ", "_"): _as_odds(odd) for short, odd in zip(_SHORT, odds, strict=True)},
        "own": [row[number] for number, row in enumerate(confused)],
    }
    return Report.of(
        "evidence",
        values,
        verdicts={
            "conductivity": odds[1] < -_STRONG,
            "share": max(odds[2:4]) < -_WEAK,
            "pattern": odds[4] > -_WEAK,
            "heat": odds[5] < _WEAK,
            "film": odds[6] < -_WEAK,
        },
        table=Table(
            ("", "ln of the odds", "critical: white oil [°C]", "oil A [°C]", *_SHORT),
            [
                (name, f"{odd:+.1f}", *cells(of_oils, ".0f"), *(f"{share:.0%}" for share in row))
                for name, odd, of_oils, row in zip(names, odds, critical, confused, strict=True)
            ],
        ),
        data={
            "log_odds": dict(zip(names, odds, strict=True)),
            "critical_celsius": dict(zip(names, critical, strict=True)),
            "chosen_on_data_of": dict(zip(names, confused, strict=True)),
        },
        figure=_draw(names, odds, confused),
    )


def _as_odds(log: float) -> str:
    """Odds in words."""
    return f"{rounded(math.exp(min(abs(log), 50.0)))} to 1 {'for' if log > 0 else 'against'} it"


def _confusions(transitions: Transitions, warmings: Array) -> list[list[float]]:
    """Share of sets of transitions, simulated by each model, at which each has most evidence.

    A transition of a model lies where its deciding temperature is critical. Its rise by another
    model is larger there by what it is larger at the measured place: both grow with velocity alike.
    """
    rng = np.random.default_rng(0)
    shares = []
    for number, model in enumerate(_MODELS.values()):
        critical = {oil: rng.normal(*its, size=_DATA) for oil, its in _CRITICAL.items()}
        limits = np.array([critical[oil] for oil in transitions.oil]).T
        carried = np.log(1 - _SHARE * transitions.film_parameter) if model.film else 0.0
        noise = rng.normal(scale=_SCATTER, size=limits.shape)
        moved = np.log(limits - transitions.bulk_celsius) + noise - warmings[number] - carried
        logs = [
            log_evidence(transitions, warming + moved, other.film)[0]
            for warming, other in zip(warmings, _MODELS.values(), strict=True)
        ]
        chosen = np.argmax(logs, axis=0)
        shares.append((np.bincount(chosen, minlength=len(_MODELS)) / _DATA).tolist())
    return shares


@in_house_style
def _draw(names: Sequence[str], odds: Sequence[float], confused: list[list[float]]) -> Figure:
    figure = Figure(figsize=(9.6, 4.6))
    left, right = figure.subplots(1, 2, width_ratios=(1.1, 1.0))
    places = range(1, len(names))
    colours = [VERMILION if odd < -_STRONG else GREY if odd < -_WEAK else BLUE for odd in odds[1:]]
    left.barh(places, odds[1:], color=colours, height=0.6)
    left.axvline(0, color="black", lw=1.0)
    for odd in (-_STRONG, _STRONG):
        left.axvline(odd, color=GREY, ls=":", lw=1.0)
    left.set_yticks(places, names[1:])
    left.invert_yaxis()
    left.set_xlabel("ln of the odds over the model as taken (dotted: 10 to 1)")
    left.set_title("by the measured transitions", loc="left")
    right.imshow(confused, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for row, shares in enumerate(confused):
        for column, share in enumerate(shares):
            colour = "white" if share > 0.6 else "black"
            right.text(column, row, f"{100 * share:.0f}", ha="center", va="center", color=colour,
                       fontsize=8)  # fmt: skip
    right.set_xticks(range(len(_SHORT)), _SHORT, rotation=45, ha="right")
    right.set_yticks(range(len(_SHORT)), _SHORT)
    right.grid(visible=False)
    right.set(xlabel="model with most evidence", ylabel="model that made the data")
    right.set_title("by its own data [%]", loc="left")
    return figure
