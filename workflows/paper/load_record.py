"""Fig. 8: a recorded load in place of its linear fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.answers.scene_wording import heating_words
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, house_style
from pipeline.quantities import in_unit
from pipeline.sweep.case import known_critical_temperature
from tribo import InputError, MeasuredLoad
from tribo.types import Array

from .publication import LOADING_RATE
from .recomputed import Recomputation, cells, texts
from .study import Study
from .transitions import HIGHEST, celsius_of, end_at, history

_RECORD, _FIT = "record", "its linear fit"
_SAME = 2.0  # [K]; within this difference a linear fit serves as well as the record

_Curves = Mapping[str, tuple[Array, Array]]
"""Times [s] and temperatures that decide [°C], by the loading."""


def fig8(study: Study) -> Recomputation:
    """Report on a point with a recorded load, with its linear fit, and with the stated rate."""
    sweep = study.scene("fig8")
    record = sweep.scene.loading
    if not isinstance(record, MeasuredLoad):
        raise InputError(f"the scene {sweep.name} must have a record, `file` under [loading]")
    load, velocity = sweep.loads[-1], sweep.velocities[-1]
    rate, onset = record.linear_fit()
    rates = {_FIT: rate, f"{LOADING_RATE:g} N/s": LOADING_RATE}
    ramps = {
        name: {"rate": f"{rate!r} N/s", "reference_load": f"{load!r} N"}
        for name, rate in rates.items()
    }
    loadings = {
        _RECORD: sweep,
        **{name: sweep.changed("loading", ramp) for name, ramp in ramps.items()},
    }
    curves, runs = {}, {}
    for name in study.stages(loadings):
        scene = loadings[name]
        *curve, end = history(scene, load, velocity, scene.conditions.critical_area_fraction)
        curves[name] = (curve[0], curve[1])
        runs[name] = {
            "duration": end.time,
            "sliding_distance": end.sliding_distance,
            "max_celsius": float(celsius_of(end_at(scene, end), HIGHEST)),
            "exceeded_celsius": float(curve[1][-1]),
        }
    recorded, fitted = runs[_RECORD], runs[_FIT]
    values: dict[str, Any] = {
        "load": load,
        "velocity": velocity,
        "heating": heating_words(sweep.conditions),
        "off": fitted["exceeded_celsius"] - recorded["exceeded_celsius"],
        "highest_off": fitted["max_celsius"] - recorded["max_celsius"],
    }
    return Recomputation.from_values(
        "fig8",
        values,
        verdicts={
            "fit": abs(values["off"]) < _SAME,
        },
        table=texts(
            ("loading", "lasts [s]", "slides [m]", f"on {_share(sweep)} [°C]", "highest [°C]"),
            [
                (
                    name,
                    *cells((run["duration"], run["sliding_distance"]), ".2f"),
                    *cells((run["exceeded_celsius"], run["max_celsius"]), ".1f"),
                )
                for name, run in runs.items()
            ],
        ),
        data={"fit": {"rate": rate, "onset": onset}, "runs": runs},
        figure=_draw(sweep, record, curves),
    )


def _share(sweep: Sweep) -> str:
    return f"{100 * sweep.conditions.critical_area_fraction:g} %"


@house_style
def _draw(sweep: Sweep, record: MeasuredLoad, curves: _Curves) -> Figure:
    figure = Figure(figsize=(7.4, 6.0))
    upper, lower = figure.subplots(2, 1, sharex=True)
    (rate, onset), load, last = record.linear_fit(), sweep.loads[-1], float(record.times[-1])
    upper.plot(record.times, record.loads, color=BLACK, lw=1.2, label="record (synthetic)")
    upper.plot(
        [onset, onset + load / rate, last], [0, load, load], color=VERMILION, ls="--",
        label=f"linear fit, {rate:.1f} N/s",
    )  # fmt: skip
    upper.set(xlim=(0, last), ylabel="normal load [N]")
    upper.legend(loc="lower right")
    looks = ((BLACK, "-"), (VERMILION, "--"), (BLUE, ":"))
    for (name, (time, values)), (colour, style) in zip(curves.items(), looks, strict=True):
        begins = float(record.times[0]) if name == _RECORD else onset
        lower.plot(time + begins, values, color=colour, ls=style, label=name)
    critical = in_unit(known_critical_temperature(sweep.conditions), "°C")
    lower.axhline(critical, color=GREY, ls=":", lw=1.2)
    lower.text(0.05, critical + 1, f"critical, {critical:g} °C", color=GREY, va="bottom")
    lower.set(xlabel="time [s]", ylabel=f"exceeded on {_share(sweep)}\nof the contact [°C]")
    lower.set_ylim(None, critical + 12)
    lower.legend(loc="lower right", title=heating_words(sweep.conditions))
    return figure
