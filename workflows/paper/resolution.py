"""Fig. 6: the highest temperature by the number of elements and of increments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from tribo.types import Array
from workflows.paper.refinement import PUBLISHED, SCHEMES, Refinement, Row, refined
from workflows.paper.report import Finding, Report, Table, judged, line, mean, spread
from workflows.paper.study import Study

_SHOWN = 48  # elements of the pressure field
_NO_EFFECT = 2.0  # K: what the text may mean by "little to no effect", 1 % in the figure


def fig6(study: Study) -> Report:
    """Highest temperature at 750 N and 1.25 m/s on other grids and with other steps."""
    refinement = refined(study)
    measured, steps = refinement.measured, refinement.by_increments
    values = {
        "load": measured.normal_load,
        "velocity": measured.velocity,
        "friction": measured.friction,
        "bulk": celsius(refinement.sweep.conditions.bulk_temperature),
    }
    on_increments = (_on_increments(refinement, name) for name in steps)
    neighbours = {name: _neighbours(field) for name, field in refinement.fields.items()}
    return Report.of(
        "fig6",
        values,
        verdicts={},
        findings=(_on_elements(refinement.by_elements), *on_increments),
        table=_table(refinement),
        data={
            "by_elements": refinement.by_elements,
            "by_increments": {name: its.highest for name, its in steps.items()},
            "neighbours": neighbours,
            "warnings": {name: its.unstable for name, its in steps.items()},
        },
        figure=_draw(refinement),
    )


def _neighbours(pressure: Array) -> float:
    """Correlation of the pressure with that of the next element along x, where it is carried."""
    rows = pressure[pressure.any(axis=1)]
    return float(np.corrcoef(rows[:-1].ravel(), rows[1:].ravel())[0, 1])


def _table(refinement: Refinement) -> Table:
    by_elements, by_increments = refinement.by_elements, refinement.by_increments
    sides = list(by_elements["maximum"])
    counts = sorted({count for steps in by_increments.values() for count in steps.highest})
    width = max(len(sides), len(counts))

    def padded(name: str, cells: Iterable[Any]) -> tuple[str, ...]:
        texts = list(cells)
        return line(name, [*texts, *[""] * (width - len(texts))], ".1f")

    labels = {
        "maximum": "highest [°C]",
        "10 %": "exceeded on 10 % [°C]",
        "one step": "highest, unworn [°C]",
    }
    return Table(
        padded("a  elements", (f"{side}²" for side in sides)),
        (
            *(padded(text, (by_elements[n][side] for side in sides)) for n, text in labels.items()),
            padded("b  increments", map(str, counts)),
            *(
                padded(name, (steps.highest.get(count, "fails") for count in counts))
                for name, steps in by_increments.items()
            ),
        ),
    )


def _on_elements(by_elements: Mapping[str, Row]) -> Finding:
    *_, coarse, fine = by_elements["maximum"]
    change = {name: _difference(row, fine, coarse) for name, row in by_elements.items()}
    values = {"coarse": coarse, "fine": fine, "change": change}
    largest = max(abs(change["maximum"]), abs(change["10 %"]))
    (finding,) = judged("fig6", values, {"elements": largest < _NO_EFFECT})
    return finding


def _on_increments(refinement: Refinement, name: str) -> Finding:
    row, unstable = refinement.by_increments[name].highest, refinement.by_increments[name].unstable
    if not row:
        (finding,) = judged("fig6", {"name": name}, {"no_contact": False})
        return finding
    first, last = min(row), max(row)
    base = PUBLISHED if PUBLISHED in row else first
    moved = _difference(row, base, last)
    values: dict[str, Any] = {
        "name": name,
        "base": base,
        "first": first,
        "last": last,
        "moved": _signed(moved),
        "first_moved": _signed(_difference(row, first, last)),
    }
    if unstable:
        values |= {
            "why": "why_unstable",
            "least": min(unstable),
            "most": max(unstable),
            "warning": unstable[max(unstable)],
        }
    if unstable and name in refinement.fields:
        implicit = refinement.fields[f"implicit, {SCHEMES[name][0]}"]
        values |= {
            "why": "why_checkerboard",
            "neighbours": _neighbours(refinement.fields[name]),
            "neighbours_implicit": _neighbours(implicit),
        }
    (finding,) = judged("fig6", values, {"increments": abs(moved) < _NO_EFFECT})
    return finding


def _difference(row: Row, number: int, other: int) -> float:
    """Temperature at a number of elements or increments above that at another [K]."""
    return float(mean(row[number]) - mean(row[other]))


def _signed(value: float) -> str:
    """One decimal and a sign, but none of zero."""
    return f"{round(value, 1) + 0.0:+.1f}" if round(value, 1) else "0.0"


@in_house_style
def _draw(refinement: Refinement) -> Figure:
    figure = Figure(figsize=(9.6, 8.2))
    halves: Any = figure.subfigures(2, 1, height_ratios=(1.15, 1))
    upper, lower = halves
    left, right = upper.subplots(1, 2, sharey=True)
    _patches(lower, refinement)
    for name, label, colour, style in (
        ("one step", "unworn, highest", BLACK, "--"),
        ("maximum", "swept wear, highest", BLUE, "-"),
        ("10 %", "swept wear, exceeded on 10 %", GREEN, "-"),
    ):
        _curve(left, refinement.by_elements[name], label, colour, style)
    left.set_xlabel("elements along each side")
    left.set_ylabel("contact temperature [°C]")
    left.set_xticks([60, 120, 240, 480])
    looks = ((BLUE, "-"), (BLUE, ":"), (VERMILION, "-"), (VERMILION, ":"))
    for (name, steps), look in zip(refinement.by_increments.items(), looks, strict=True):
        if steps.highest:
            _curve(right, steps.highest, name, *look)
    right.set_xlabel("increments of the ramp")
    right.axvline(PUBLISHED, color=GREY, lw=0.9)
    bottom, top = left.get_ylim()
    left.set_ylim(bottom, top + 0.3 * (top - bottom))
    for letter, axes in (("a", left), ("b", right)):
        axes.set_title(letter, loc="left")
        axes.legend(loc="upper right")
    return figure


def _curve(axes: Axes, row: Row, name: str, colour: str, style: str) -> None:
    numbers = sorted(row)
    values = [row[n] for n in numbers]
    bars = spread(values) if len(values[0]) > 1 else None
    axes.errorbar(
        numbers, mean(values), bars, color=colour, ls=style, marker="o", ms=3.5, capsize=2,
        label=name,
    )  # fmt: skip


def _patches(figure: SubFigure, refinement: Refinement) -> None:
    """Draw the middle of the contact after explicit and implicit steps, on one scale."""
    fields, sweep = dict(sorted(refinement.fields.items())), refinement.sweep  # explicit first
    if not fields:
        return
    row = np.atleast_1d(figure.subplots(1, len(fields), sharey=True))
    dx, dy = (1e6 * side * sweep.fidelity.pixels_per_element for side in sweep.pixels.spacing)
    parts = []
    for pressure in fields.values():
        (nx, ny), gigapascal = pressure.shape, pressure / 1e9
        i, j = min(_SHOWN, nx), min(_SHOWN, ny)
        parts.append(gigapascal[(nx - i) // 2 : (nx + i) // 2, (ny - j) // 2 : (ny + j) // 2])
    highest = max(float(part.max()) for part in parts)
    for letter, axes, name, part in zip("cd", row, fields, parts, strict=False):
        image = axes.imshow(
            part.T, origin="lower", cmap="viridis_r", vmin=0, vmax=highest, aspect="auto",
            extent=(0, dx * part.shape[0], 0, dy * part.shape[1]), interpolation="nearest",
        )  # fmt: skip
        axes.set_title(f"{letter}  {name}, {refinement.pictured} increments", loc="left")
        axes.set_xlabel("x [µm]")
        axes.grid(visible=False)
    row[0].set_ylabel("y [µm], a part of the contact")
    figure.colorbar(image, ax=list(row), label="pressure [GPa]", pad=0.02)
