"""Figures of samples: probability of severe wear, sensitivity to the inputs, and the posterior."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.laboratory import laboratory_tests, model_error
from pipeline.analysis.results import Results
from pipeline.figures import style
from pipeline.figures.overlays import mark_tests, number_tests
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from pipeline.quantities import shown_in
from pipeline.scene.units import typeset
from pipeline.sweep.condition_words import heating_words, severe_words
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.fields import single_field
from pipeline.uncertain.inputs import QUANTILES
from pipeline.uncertain.posterior import Judged, Posterior
from pipeline.uncertain.sensitivity import Sensitivity

_COLOURS = (VERMILION, BLUE, GREEN, PURPLE, ORANGE, SKY, GREY)
_BINS = 40


_LOADS, _VELOCITIES = 45, 121  # nodes at which the probability is drawn


@style.house_style
def draw_probability(data: Results, log: bool = False) -> Figure:
    """Draw the probability of severe wear over velocity and load; `log` for logarithmic axes."""
    field = single_field(data)
    ensemble, weighed, scatter = field.ensemble, field.posterior, model_error(data, field)
    figure, axes = style.canvas((7.2, 5.4))
    x = np.linspace(*ensemble.velocities, _VELOCITIES)
    y = np.linspace(ensemble.loads[0], ensemble.loads[-1], _LOADS)
    p = field.probability(y[:, None], x, scatter)
    (low, high), levels = style.PALE, np.linspace(0, 1, 21)
    filled = axes.contourf(x, y, p, levels, cmap=style.RISK_COLOURS, vmin=low, vmax=high)
    axes.grid(visible=False)
    lines = axes.contour(
        x, y, p, levels=QUANTILES, colors=BLACK, linewidths=(1.0, 1.8, 1.0),
        linestyles=("dashed", "solid", "dashed"),
    )  # fmt: skip
    axes.clabel(lines, fmt=lambda level: f"{100 * level:g} %", fontsize=9)
    bar = figure.colorbar(filled, ax=axes, ticks=np.linspace(0, 1, 6))
    bar.set_label("probability that the next run is severe")
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")
    tests = laboratory_tests(data)
    (columns,) = np.nonzero(((p > 0.002) & (p < 0.998)).any(axis=0))
    if columns.size:  # show velocities where the outcome is uncertain at some load, with a margin
        left, right = x[max(columns[0] - 2, 0)], x[min(columns[-1] + 2, len(x) - 1)]
        tested = [test.velocity for test in tests if x[0] <= test.velocity <= x[-1]]
        axes.set_xlim(min(left, *tested, right), max(right, *tested, left))
    bulk = ensemble.conditions.bulk_temperature
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    inside = {
        k: one for k, one in number_tests(tests).items()
        if low <= one.velocity <= high and bottom <= one.normal_load <= top
    }  # fmt: skip
    for mark in mark_tests(axes, inside, bulk, bulk):
        mark.set_clip_on(False)  # tests are often at the lowest and the highest load
    if left_out := len(tests) - len(inside):
        beyond = "test is" if left_out == 1 else "tests are"
        axes.plot([], [], ls="none", label=f"{left_out} {beyond} outside the figure")
    if log:
        axes.set(xscale="log", yscale="log")
        style.plain_numbers(axes)
    basis = "inputs as assumed, before any measurement"
    if weighed:
        basis = f"given {weighed.evidence}"
        if weighed.draws.misfit:
            basis += ", which the model does not fit"
    basis = "; ".join([basis, *map(str, ensemble.fixed)])
    style.write_title(axes, f"{style.as_text(ensemble.title)}\n{basis}")
    caption = f"{_conditions(ensemble)}\nthe model's own error: {scatter.text}"
    style.legend_below(figure, ncols=2, caption=caption)
    return figure


def _conditions(ensemble: Ensemble) -> str:
    """Describe the criterion of severe wear, the friction, and the inputs that samples vary."""
    drawn = [one.path for one in ensemble.unknown]
    conditions, severe = ensemble.conditions, ""
    if conditions.critical_temperature is not None:
        severe = f"severe wear: {severe_words(conditions, drawn)}; "
    return f"{severe}{heating_words(conditions, drawn)}; samples vary {', '.join(drawn)}"


@style.house_style
def draw_sensitivity(sensitivity: Sensitivity, title: str) -> Figure:
    """Draw the Sobol' indices of the critical velocity by load; `title` is the scene's."""
    figure, axes = style.canvas((7.6, 2.8 + 0.55 * len(sensitivity.unknown)))
    order = np.argsort(sensitivity.first.mean(axis=0))
    has_total = np.isfinite(sensitivity.total).all()
    number = len(sensitivity.loads)
    height = 0.8 / number
    for i, load in enumerate(sensitivity.loads):
        positions = np.arange(len(order)) + ((number - 1) / 2 - i) * height
        values = sensitivity.first[i, order]
        low, high = sensitivity.first_interval[:, i, order]
        axes.barh(
            positions, values, 0.9 * height, color=_COLOURS[i % len(_COLOURS)], alpha=0.85,
            label=f"{load:g} N, ± {100 * sensitivity.spread[i]:.2g} %",
            xerr=np.maximum([values - low, high - values], 0.0),
            error_kw={"ecolor": BLACK, "elinewidth": 0.8, "capsize": 2},
        )  # fmt: skip
        if has_total:
            total = sensitivity.total[i, order]
            axes.plot(total, positions, ls="none", marker="|", ms=8, mew=1.4, color=BLACK)
    axes.set_yticks(
        range(len(order)), [style.entry_label(sensitivity.unknown[k].path) for k in order]
    )
    axes.grid(visible=False, axis="y")
    axes.set_xlim(left=0.0)
    label = "share of the variance of the critical velocity"
    axes.set_xlabel(label + (", given the measurements" if sensitivity.given_measured else ""))
    style.write_title(figure, style.as_text(title))
    bars = "bar: first index, with its 90 % interval" + ("; tick: total index" if has_total else "")
    caption = f"{bars}\nload, and spread of the velocity there"
    style.legend_below(figure, ncols=min(number, 4), caption=caption)
    return figure


@style.house_style
def draw_posterior(posterior: Posterior) -> Figure:
    """Draw the distribution of each input before and after the tests.

    If transitions were measured, a further panel compares computed with measured velocities.
    """
    unknown = posterior.unknown
    transitions = [judged for judged in posterior.judged if "outcome" not in judged.test]
    panels = len(unknown) + bool(transitions)
    columns = min(3, panels)
    rows = -(-panels // columns)
    figure = style.Picture(figsize=(3.4 * columns, 3.0 * rows + 0.9))
    axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    for number, (quantity, panel) in enumerate(zip(unknown, axes, strict=False)):
        values = shown_in(posterior.prior.inputs[:, number], quantity.shown)
        low, high = (posterior.prior.quantile(values, share) for share in (0.001, 0.999))
        bins = np.linspace(low, high, _BINS)
        if quantity.kind == "list":
            listed = np.sort(shown_in(np.array(quantity.parameters), quantity.shown))
            middles = (listed[1:] + listed[:-1]) / 2
            bins = np.array([2 * listed[0] - middles[0], *middles, 2 * listed[-1] - middles[-1]])
        for draws, colour, label in (
            (posterior.prior, GREY, "prior, before the tests"),
            (posterior.draws, BLUE, "posterior, after the tests"),
        ):
            panel.hist(
                shown_in(draws.inputs[:, number], quantity.shown), bins.tolist(),
                weights=draws.weights, density=True, histtype="stepfilled", color=colour,
                alpha=0.45, ec=colour, label=label,
            )  # fmt: skip
        unit = typeset(style.as_text(quantity.shown))
        label = style.entry_label(quantity.path) + (unit and f"\n[{unit}]")
        panel.set_xlabel(label, fontsize=9)
        panel.ticklabel_format(axis="x", scilimits=(-3, 3), useMathText=True)
        panel.set_yticks([])
        panel.grid(visible=False)
    if transitions:
        _parity(axes[len(unknown)], transitions, posterior.inferred_scatter[1])
    for panel in axes[panels:]:
        panel.set_axis_off()
    style.write_title(figure, style.as_text(posterior.ensemble.title))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _parity(axes: Axes, transitions: Sequence[Judged], inferred: float) -> None:
    """Plot computed against measured velocities of `transitions`, with 90 % intervals.

    `inferred` is the relative scatter of measured velocities whose scatter is not stated.
    """
    tests = [judged.test for judged in transitions]
    measured = np.array([test["velocity"] for test in tests])
    scatter = [test.get("velocity_scatter", inferred * test["velocity"]) for test in tests]
    low, middle, high = np.array([judged.critical_velocity for judged in transitions]).T
    ends = np.array([0.9 * min(measured.min(), low.min()), 1.1 * max(measured.max(), high.max())])
    axes.plot(ends, ends, color=GREY, lw=1.0)
    axes.errorbar(
        measured, middle, [middle - low, high - middle], scatter, ls="none",
        marker="D", ms=4.5, color=VERMILION, elinewidth=1.0,
    )  # fmt: skip
    for entry, velocity in zip(tests, middle, strict=True):
        is_above = velocity > entry["velocity"]  # the line of equal velocities
        axes.annotate(
            f"{entry['normal_load']:g} N", (entry["velocity"], velocity),
            (-6, 5) if is_above else (6, -10), ha="right" if is_above else "left",
            textcoords="offset points", fontsize=8, color=GREY,
        )  # fmt: skip
    axes.set_xlabel("measured velocity, with scatter [m/s]", fontsize=9)
    axes.set_ylabel("computed, with 90 % interval [m/s]", fontsize=9)
