"""Fig. 6: what the highest temperature owes to the number of elements and of increments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from tribo.types import Array
from workflows.paper.refinement import PUBLISHED, SCHEMES, Refinement, Row, refined
from workflows.paper.report import Finding, Report, Table, mean_and_spread, statistics
from workflows.paper.study import Study

_SHOWN = 48  # elements of the pressure field
_NO_EFFECT = 2.0  # K: what the text may mean by "little to no effect", 1 % in the figure


def fig6(study: Study) -> Report:
    """Highest temperature at 750 N and 1.25 m/s on other grids and with other steps."""
    found = refined(study)
    load, velocity = found.measured.normal_load, found.measured.velocity
    steps = found.by_increments
    return Report(
        name="fig6",
        title=f"highest temperature at {load:g} N, {velocity:g} m/s against elements and steps",
        table=_table(found),
        findings=(_on_elements(found), *(_on_increments(found, name) for name in steps)),
        notes=(
            f"Friction {found.measured.friction:g}, bulk "
            f"{celsius(found.sweep.conditions.bulk_temperature):g} °C. "
            "The paper's lowest velocity is not printed; that of Table 4 at its highest load is "
            "taken.",
            "The paper prints no numbers of the points; the comparison is with what its text says.",
        ),
        data={
            "by_elements": {name: _by_text(row) for name, row in found.by_elements.items()},
            "by_increments": {name: _by_text(each.highest) for name, each in steps.items()},
            "neighbours": {name: _neighbours(field) for name, field in found.fields.items()},
            "warnings": {name: _by_text(each.unstable) for name, each in steps.items()},
        },
        figure=_draw(found),
    )


def _by_text(row: Mapping[int, Any]) -> dict[str, Any]:
    return {str(number): value for number, value in row.items()}


def _neighbours(pressure: Array) -> float:
    """Correlation of the pressure with that of the next element along x, where it is carried."""
    rows = pressure[pressure.any(axis=1)]
    return float(np.corrcoef(rows[:-1].ravel(), rows[1:].ravel())[0, 1])


def _table(found: Refinement) -> Table:
    sides = list(found.by_elements["maximum"])
    counts = sorted({count for steps in found.by_increments.values() for count in steps.highest})
    width = max(len(sides), len(counts))

    def row(name: str, cells: Iterable[str]) -> tuple[str, ...]:
        given = list(cells)
        return (name, *given, *[""] * (width - len(given)))

    def values(name: str, given: Row, numbers: Iterable[int]) -> tuple[str, ...]:
        return row(name, (mean_and_spread(given[n], 1) if n in given else "fails" for n in numbers))

    labels = {
        "maximum": "highest [°C]",
        "10 %": "exceeded on 10 % [°C]",
        "one step": "highest, unworn [°C]",
    }
    return Table(
        row("a  elements", (f"{side}²" for side in sides)),
        (
            *(values(label, found.by_elements[key], sides) for key, label in labels.items()),
            row("b  increments", map(str, counts)),
            *(values(name, each.highest, counts) for name, each in found.by_increments.items()),
        ),
    )


def _on_elements(found: Refinement) -> Finding:
    *_, coarse, fine = found.by_elements["maximum"]
    change = {key: _difference(row, fine, coarse) for key, row in found.by_elements.items()}
    return Finding(
        "from 240² to 480² elements there is little to no effect",
        f"from {coarse}² to {fine}² the highest temperature moves by {change['maximum']:+.1f} K "
        f"with wear, {change['one step']:+.1f} K without; that exceeded on 10 % by "
        f"{change['10 %']:+.1f} K",
        max(abs(change["maximum"]), abs(change["10 %"])) < _NO_EFFECT,
    )


def _on_increments(found: Refinement, name: str) -> Finding:
    said = "above 100 increments the temperature does not change"
    row = found.by_increments[name].highest
    if not row:
        return Finding(said, f"{name}: no contact was found", agrees=False)
    first, last = min(row), max(row)
    base = PUBLISHED if PUBLISHED in row else first
    moved = _difference(row, base, last)
    return Finding(
        said,
        f"{name}: {base} increments are {_signed(moved)} K off {last}, "
        f"{first} are {_signed(_difference(row, first, last))} K off",
        abs(moved) < _NO_EFFECT,
        _instability(found, name),
    )


def _instability(found: Refinement, name: str) -> str:
    """Why the increments of a scheme are unstable, if they are."""
    told, fields = found.by_increments[name].unstable, found.fields
    if not told:
        return ""
    why = (
        f"Its steps are unstable from {min(told)} to {max(told)} increments, and it warns: "
        f"{told[max(told)]}."
    )
    if name not in fields:
        return why
    pattern, _ = SCHEMES[name]
    return (
        f"{why} Its pressure is a checkerboard (c): next elements correlate by "
        f"{_neighbours(fields[name]):.2f}, with implicit steps (d) by "
        f"{_neighbours(fields[f'implicit, {pattern}']):.2f}."
    )


def _difference(row: Row, number: int, other: int) -> float:
    """Temperature at a number of elements or increments above that at another [K]."""
    return statistics(row[number])[0] - statistics(row[other])[0]


def _signed(value: float) -> str:
    """One decimal and a sign, but none of zero."""
    return f"{round(value, 1) + 0.0:+.1f}" if round(value, 1) else "0.0"


@in_house_style
def _draw(found: Refinement) -> Figure:
    figure = Figure(figsize=(9.6, 8.2))
    halves: Any = figure.subfigures(2, 1, height_ratios=(1.15, 1))
    upper, lower = halves
    left, right = upper.subplots(1, 2, sharey=True)
    _patches(lower, found)
    _draw_elements(left, found)
    _draw_increments(right, found)
    bottom, top = left.get_ylim()
    left.set_ylim(bottom, top + 0.3 * (top - bottom))
    left.legend(loc="upper right")
    right.legend(loc="upper right")
    return figure


def _draw_elements(axes: Axes, found: Refinement) -> None:
    for key, name, colour, style in (
        ("one step", "unworn, highest", BLACK, "--"),
        ("maximum", "swept wear, highest", BLUE, "-"),
        ("10 %", "swept wear, exceeded on 10 %", GREEN, "-"),
    ):
        _curve(axes, found.by_elements[key], name, colour, style)
    axes.set_xlabel("elements along each side")
    axes.set_ylabel("contact temperature [°C]")
    axes.set_xticks([60, 120, 240, 480])
    axes.set_title("a", loc="left")


def _draw_increments(axes: Axes, found: Refinement) -> None:
    for (name, steps), colour, style in zip(
        found.by_increments.items(),
        (BLUE, BLUE, VERMILION, VERMILION),
        ("-", ":", "-", ":"),
        strict=True,
    ):
        if steps.highest:
            _curve(axes, steps.highest, name, colour, style)
    axes.set_xlabel("increments of the ramp")
    axes.set_title("b", loc="left")
    axes.axvline(PUBLISHED, color=GREY, lw=0.9)


def _patches(figure: SubFigure, found: Refinement) -> None:
    """Draw the middle of the contact after explicit and implicit steps, on one scale."""
    fields, sweep = dict(sorted(found.fields.items())), found.sweep  # explicit first
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
        axes.set_title(f"{letter}  {name}, {found.shown} increments", loc="left")
        axes.set_xlabel("x [µm]")
        axes.grid(visible=False)
    row[0].set_ylabel("y [µm], a part of the contact")
    figure.colorbar(image, ax=list(row), label="pressure [GPa]", pad=0.02)


def _curve(axes: Axes, row: Row, name: str, colour: str, style: str) -> None:
    at = sorted(row)
    mean, spread = np.array([statistics(row[n]) for n in at]).T
    axes.errorbar(
        at, mean, spread if spread.any() else None, color=colour, ls=style, marker="o", ms=3.5,
        capsize=2, label=name,
    )  # fmt: skip
