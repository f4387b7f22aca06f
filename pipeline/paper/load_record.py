"""Fig. 8: a recorded load in place of its linear fit."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, celsius, heating, in_house_style
from pipeline.paper.report import Finding, Report, Table
from pipeline.paper.study import Study, summary_of
from pipeline.sweep.criterion import contact_temperature
from pipeline.sweep.model import Sweep
from tribo import MeasuredLoad, Ramp, simulate
from tribo.types import Array

RATE = 150.0
"""The paper's loading rate [N/s]."""
_SAME = 2.0  # K: within what a linear fit serves as well as the record


def synthetic_record(
    load: float = 602.0,
    rate: float = RATE,
    rounding: float = 0.2,
    noise: float = 1.0,
    onset: float = 0.3,
    seed: int = 0,
) -> str:
    r"""A load record as the paper describes its own, which is not published, as CSV.

    A ramp that the compliance of the rig rounds off at both ends, as a lag of first order does,
    and the noise of a load cell.

    Parameters
    ----------
    load : float
        Load at the end [N].
    rate : float
        Rate at which the load grows [N/s].
    rounding : float
        Time constant of the lag [s].
    noise : float
        Standard deviation [N]; the paper's load cell is good to 2 N, taken as two of these.
    onset : float
        When the pin touches the disk [s].
    seed : int
        Seed of the noise.

    Examples
    --------
    >>> print(*synthetic_record().splitlines()[4:7], sep="\n")
    time [s],normal load [N]
    0.00,0.1
    0.02,-0.1
    """
    t = np.arange(0.0, 6.0, 0.02)

    def lagging(s: Array) -> Array:
        s = np.maximum(s, 0.0)
        risen: Array = rate * (s - rounding * -np.expm1(-s / rounding))
        return risen

    F = lagging(t - onset) - lagging(t - onset - load / rate)
    F += noise * np.random.default_rng(seed).standard_normal(len(t))
    head = (
        "# Synthetic: the record of Fig. 8 of Bosman & de Rooij is not published as numbers. Made\n"
        f"# from their description by pipeline.paper: {rate:g} N/s to {load:g} N from {onset:g} s "
        f"on,\n# rounded off by a lag of {rounding:g} s, with a noise of {noise:g} N "
        "(standard deviation).\n#\n"
    )
    rows = "\n".join(f"{time:.2f},{value:.1f}" for time, value in zip(t, F, strict=True))
    return f"{head}time [s],normal load [N]\n{rows}\n"


class _Run(NamedTuple):
    time: Array
    temperature: Array  # exceeded on the failing share of the contact [°C]
    duration: float
    distance: float
    highest: float
    exceeded: float


def fig8(study: Study) -> Report:
    """The same point through a recorded load, its linear fit, and the stated rate."""
    sweep = study.scene("fig8")
    record = sweep.loading
    if not isinstance(record, MeasuredLoad):
        raise TypeError("Fig. 8 is about a recorded load")
    if study.preset is not None:  # a preset asks for the temperature at the end only
        interval = max(1, sweep.fidelity.increments // 10)
        sweep = replace(sweep, fidelity=replace(sweep.fidelity, temperature_interval=interval))
    load, velocity = sweep.loads[-1], sweep.velocities[-1]
    rate, onset = record.linear_fit()
    runs = {}
    for name, loading in (
        ("record", record),
        ("its linear fit", record.ramp()),
        (f"{RATE:g} N/s", Ramp(RATE, load)),
    ):
        study.tell(f"{name}: {load:g} N at {velocity:g} m/s")
        runs[name] = _run(replace(sweep, loading=loading), load, velocity)

    recorded, fitted, _ = runs.values()
    off = fitted.exceeded - recorded.exceeded
    share = f"{100 * sweep.conditions.failing_share:g} %"
    findings = (
        Finding(
            f"the load grows at {RATE:g} N/s",
            f"the fit between 10 and 90 % of the load gives {rate:.1f} N/s",
            abs(rate / RATE - 1) < 0.02,
            "The record was made so.",
        ),
        Finding(
            "a linear fit may stand for the record",
            f"at full load the fit is {off:+.2f} K off in the temperature exceeded on {share} and "
            f"{fitted.highest - recorded.highest:+.2f} K in the highest",
            abs(off) < _SAME,
            f"The record takes {recorded.duration - fitted.duration:.2f} s longer because of its "
            f"rounded ends, and slides {recorded.distance - fitted.distance:.2f} m farther.",
        ),
    )
    return Report(
        name="fig8",
        title=f"a recorded load (synthetic) and its linear fit, {load:g} N at {velocity:g} m/s",
        table=Table(
            ("loading", "lasts [s]", "slides [m]", f"on {share} [°C]", "highest [°C]"),
            tuple(
                (
                    name,
                    f"{run.duration:.2f}",
                    f"{run.distance:.2f}",
                    f"{run.exceeded:.1f}",
                    f"{run.highest:.1f}",
                )
                for name, run in runs.items()
            ),
        ),
        findings=findings,
        notes=(
            "The record is synthetic: the paper's is not published as numbers. It is made from "
            "the paper's description, and can be replaced by a measured one in the scene.",
            f"{heating(sweep.conditions)}; one surface, its correlation length our choice.",
        ),
        data={
            "fit": {"rate": rate, "onset": onset},
            "runs": {
                name: {
                    "duration": run.duration,
                    "sliding_distance": run.distance,
                    "max_celsius": run.highest,
                    "exceeded_celsius": run.exceeded,
                }
                for name, run in runs.items()
            },
        },
        figure=_draw(record, rate, onset, load, runs, sweep),
    )


def _run(scene: Sweep, load: float, velocity: float) -> _Run:
    conditions = scene.conditions
    times, temperatures = [0.0], [float(celsius(contact_temperature(0.0, conditions)))]
    for state in simulate(scene, load, velocity):
        if state.heat is not None:
            end = summary_of(scene, state)
            times.append(state.time)
            temperatures.append(end.exceeded(conditions))
    return _Run(
        np.array(times),
        np.array(temperatures),
        state.time,
        state.sliding_distance,
        end.highest(conditions),
        temperatures[-1],
    )


@in_house_style
def _draw(
    record: MeasuredLoad,
    rate: float,
    onset: float,
    load: float,
    runs: dict[str, _Run],
    sweep: Sweep,
) -> Figure:
    figure = Figure(figsize=(7.4, 6.0))
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.plot(record.times, record.loads, color=BLACK, lw=1.2, label="record (synthetic)")
    end = onset + load / rate
    upper.plot(
        [onset, end, record.times[-1]], [0, load, load], color=VERMILION, ls="--",
        label=f"linear fit, {rate:.1f} N/s",
    )  # fmt: skip
    upper.set_ylabel("normal load [N]")
    upper.legend(loc="lower right")
    begins = {"record": float(record.times[0]), "its linear fit": onset}
    for (name, run), (colour, style) in zip(
        runs.items(), ((BLACK, "-"), (VERMILION, "--"), (BLUE, ":")), strict=True
    ):
        shift = begins.get(name, onset)
        lower.plot(run.time + shift, run.temperature, color=colour, ls=style, label=name)
    conditions = sweep.conditions
    critical = celsius(conditions.known_critical_temperature())
    lower.axhline(critical, color=GREY, ls=":", lw=1.2)
    lower.text(0.05, critical + 1, f"critical, {critical:g} °C", color=GREY, va="bottom")
    lower.set_ylabel(f"exceeded on {100 * conditions.failing_share:g} %\nof the contact [°C]")
    lower.set_xlabel("time [s]")
    lower.set_ylim(None, critical + 12)
    lower.legend(loc="lower right", title=heating(conditions))
    upper.set_xlim(0, record.times[-1])
    return figure
