"""Fig. 6: what the highest temperature owes to the number of elements and of increments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.paper.report import Finding, Report, Table, mean_and_spread, statistics
from pipeline.paper.study import End, Study, summary_of
from pipeline.sweep.model import Sweep
from tribo import ConvergenceError, simulate, warnings
from tribo.types import Array

BLOCKS = (8, 6, 4, 3, 2, 1)
INCREMENTS = (20, 30, 40, 50, 75, 100, 150, 200)
_PUBLISHED = 100  # increments
_SHOWN = 48  # elements of the pressure field
_NO_EFFECT = 2.0  # K: what the text may mean by "little to no effect", 1 % in the figure
_SCHEMES: dict[str, tuple[str, Mapping[str, Any]]] = {
    "implicit, swept": ("swept", {"wear_scheme": "implicit"}),
    "explicit, swept": ("swept", {"wear_scheme": "explicit"}),
    "implicit, local": ("local", {"wear_scheme": "implicit"}),
    "explicit, local (as published)": ("local", {"wear_scheme": "explicit"}),
}


def fig6(study: Study) -> Report:
    """Highest temperature at 750 N and 1.25 m/s on other grids and with other steps."""
    sweep = study.scene("irg_transition")
    measured = max(sweep.measured, key=lambda entry: entry.normal_load)
    load, velocity = measured.normal_load, measured.velocity
    conditions = sweep.conditions.changed(friction=measured.friction)
    blocks = [n for n in BLOCKS if sweep.preset is None or n >= sweep.fidelity.pixels_per_element]
    counts = [n for n in INCREMENTS if study.preset is None or n <= 50]
    surfaces = [sweep.on_surface(seed) for seed in study.seeds(1)]

    by_elements: dict[str, dict[int, list[float]]] = {"maximum": {}, "10 %": {}, "one step": {}}
    for block in blocks:
        side = sweep.pixels.shape[0] // block
        study.tell(f"{side} × {side} elements")
        on_grid = [
            _with(surface, pixels_per_element=block, history_coarsening=1, averaging="mean")
            for surface in surfaces
        ]
        ends = [_end(scene, load, velocity)[0] for scene in on_grid]
        single = [_end(replace(scene, wear=None), load, velocity)[0] for scene in on_grid]
        by_elements["maximum"][side] = [end.highest(conditions) for end in ends]
        by_elements["10 %"][side] = [end.exceeded(conditions) for end in ends]
        by_elements["one step"][side] = [end.highest(conditions) for end in single]

    fields: dict[str, Array] = {}
    shown = max(count for count in counts if count <= _PUBLISHED)
    by_increments: dict[str, dict[int, list[float]]] = {name: {} for name in _SCHEMES}
    unstable: dict[str, dict[int, str]] = {name: {} for name in _SCHEMES}
    for name, (pattern, changes) in _SCHEMES.items():
        for count in counts:
            study.tell(f"{name}: {count} increments")
            for surface in surfaces:
                scene = _with(
                    replace(surface, wear=replace(surface.wear, pattern=pattern)),  # type: ignore[type-var]
                    increments=count,
                    history_coarsening=1,
                    **changes,
                )
                try:
                    end, told, pressure = _end(scene, load, velocity)
                except ConvergenceError as error:
                    unstable[name][count] = str(error)
                    continue
                by_increments[name].setdefault(count, []).append(end.highest(conditions))
                if pattern == "local" and count == shown and surface is surfaces[0]:
                    fields[name] = pressure
                for line in told:
                    if "explicit" in line:
                        unstable[name][count] = line

    return Report(
        name="fig6",
        title=f"highest temperature at {load:g} N, {velocity:g} m/s against elements and steps",
        table=_table(by_elements, by_increments),
        findings=_findings(by_elements, by_increments, unstable, fields),
        notes=(
            f"Friction {conditions.friction:g}, bulk {celsius(conditions.bulk_temperature):g} °C. "
            "The paper's lowest velocity is not printed; taken is that of Table 4 at its highest "
            "load.",
            "The points of the figure are not printed as numbers; compared is what the text says.",
        ),
        data={
            "by_elements": {
                name: {str(n): values for n, values in row.items()}
                for name, row in by_elements.items()
            },
            "by_increments": {
                name: {str(n): values for n, values in row.items()}
                for name, row in by_increments.items()
            },
            "neighbours": {name: _neighbours(field) for name, field in fields.items()},
            "warnings": {
                name: {str(n): text for n, text in row.items()} for name, row in unstable.items()
            },
        },
        figure=_draw(by_elements, by_increments, fields, shown, sweep),
    )


def _with(scene: Sweep, **changes: Any) -> Sweep:
    return replace(scene, fidelity=replace(scene.fidelity, **changes))


def _end(scene: Sweep, load: float, velocity: float) -> tuple[End, list[str], Array]:
    *_, state = simulate(scene, load, velocity)
    return (
        summary_of(scene, state),
        [str(warning) for warning in warnings(scene, state)],
        state.pressure,
    )


def _neighbours(pressure: Array) -> float:
    """Correlation of the pressure with that of the next element along x, where it is carried."""
    rows = pressure[pressure.any(axis=1)]
    return float(np.corrcoef(rows[:-1].ravel(), rows[1:].ravel())[0, 1])


def _table(
    by_elements: Mapping[str, Mapping[int, list[float]]],
    by_increments: Mapping[str, Mapping[int, list[float]]],
) -> Table:
    sides = list(by_elements["maximum"])
    counts = sorted({count for row in by_increments.values() for count in row})
    width = max(len(sides), len(counts))

    def row(name: str, cells: Iterable[str]) -> tuple[str, ...]:
        given = list(cells)
        return (name, *given, *[""] * (width - len(given)))

    names = {
        "maximum": "highest [°C]",
        "10 %": "exceeded on 10 % [°C]",
        "one step": "highest, unworn [°C]",
    }
    return Table(
        row("a  elements", (f"{side}²" for side in sides)),
        (
            *(
                row(label, (mean_and_spread(by_elements[key][side], 1) for side in sides))
                for key, label in names.items()
            ),
            row("b  increments", map(str, counts)),
            *(
                row(name, (mean_and_spread(v[n], 1) if n in v else "fails" for n in counts))
                for name, v in by_increments.items()
            ),
        ),
    )


def _findings(
    by_elements: Mapping[str, Mapping[int, list[float]]],
    by_increments: Mapping[str, Mapping[int, list[float]]],
    unstable: Mapping[str, Mapping[int, str]],
    fields: Mapping[str, Array],
) -> tuple[Finding, ...]:
    *_, coarse, fine = list(by_elements["maximum"])
    change = {
        key: statistics(row[fine])[0] - statistics(row[coarse])[0]
        for key, row in by_elements.items()
    }
    elements = Finding(
        "from 240² to 480² elements there is little to no effect",
        f"from {coarse}² to {fine}² the highest temperature moves by {change['maximum']:+.1f} K "
        f"with wear, {change['one step']:+.1f} K without; that exceeded on 10 % by "
        f"{change['10 %']:+.1f} K",
        max(abs(change["maximum"]), abs(change["10 %"])) < _NO_EFFECT,
    )
    said = "above 100 increments the temperature does not change"
    steps = []
    for name, row in by_increments.items():
        counts = sorted(row)
        if not counts:
            steps.append(Finding(said, f"{name}: no contact was found", agrees=False))
            continue
        base, last = (100 if 100 in row else counts[0]), counts[-1]
        first = statistics(row[counts[0]])[0] - statistics(row[last])[0]
        moved = statistics(row[base])[0] - statistics(row[last])[0]
        told = unstable[name]
        why = ""
        if told:
            why = (
                f"Its steps are unstable from {min(told)} to {max(told)} increments, and it warns: "
                f"{told[max(told)]}."
            )
            if name in fields:
                why += (
                    " Its pressure is a checkerboard (c): next elements correlate by "
                    f"{_neighbours(fields[name]):.2f}, with implicit steps (d) by "
                    f"{_neighbours(fields[_implicit(name)]):.2f}."
                )
        steps.append(
            Finding(
                said,
                f"{name}: {base} increments are {_signed(moved)} K off {last}, "
                f"{counts[0]} are {_signed(first)} K off",
                abs(moved) < _NO_EFFECT,
                why,
            )
        )
    return (elements, *steps)


def _implicit(name: str) -> str:
    pattern, _ = _SCHEMES[name]
    return f"implicit, {pattern}"


def _signed(value: float) -> str:
    """One decimal and a sign, but none of zero."""
    return f"{round(value, 1) + 0.0:+.1f}" if round(value, 1) else "0.0"


@in_house_style
def _draw(
    by_elements: Mapping[str, Mapping[int, list[float]]],
    by_increments: Mapping[str, Mapping[int, list[float]]],
    fields: Mapping[str, Array],
    shown: int,
    sweep: Sweep,
) -> Figure:
    figure = Figure(figsize=(9.6, 8.2))
    halves: Any = figure.subfigures(2, 1, height_ratios=(1.15, 1))
    upper, lower = halves
    left, right = upper.subplots(1, 2, sharey=True)
    _patches(lower, fields, shown, sweep)
    for key, name, colour, style in (
        ("one step", "unworn, highest", BLACK, "--"),
        ("maximum", "swept wear, highest", BLUE, "-"),
        ("10 %", "swept wear, exceeded on 10 %", GREEN, "-"),
    ):
        _curve(left, by_elements[key], name, colour, style)
    for name, colour, style in zip(
        by_increments, (BLUE, BLUE, VERMILION, VERMILION), ("-", ":", "-", ":"), strict=True
    ):
        if by_increments[name]:
            _curve(right, by_increments[name], name, colour, style)
    left.set_xlabel("elements along each side")
    left.set_ylabel("contact temperature [°C]")
    left.set_xticks([60, 120, 240, 480])
    right.set_xlabel("increments of the ramp")
    left.set_title("a", loc="left")
    right.set_title("b", loc="left")
    bottom, top = left.get_ylim()
    left.set_ylim(bottom, top + 0.3 * (top - bottom))
    left.legend(loc="upper right")
    right.legend(loc="upper right")
    right.axvline(100, color=GREY, lw=0.9)
    return figure


def _patches(figure: SubFigure, fields: Mapping[str, Array], shown: int, sweep: Sweep) -> None:
    """Draw the middle of the contact after explicit and implicit steps, on one scale."""
    if not fields:
        return
    names = sorted(fields)  # explicit first
    row = np.atleast_1d(figure.subplots(1, len(names), sharey=True))
    dx, dy = (1e6 * side * sweep.fidelity.pixels_per_element for side in sweep.pixels.spacing)
    parts = []
    for name in names:
        (nx, ny), field = fields[name].shape, fields[name] / 1e9
        i, j = min(_SHOWN, nx), min(_SHOWN, ny)
        parts.append(field[(nx - i) // 2 : (nx + i) // 2, (ny - j) // 2 : (ny + j) // 2])
    highest = max(float(part.max()) for part in parts)
    for letter, axes, name, part in zip("cd", row, names, parts, strict=False):
        image = axes.imshow(
            part.T, origin="lower", cmap="viridis_r", vmin=0, vmax=highest, aspect="auto",
            extent=(0, dx * part.shape[0], 0, dy * part.shape[1]), interpolation="nearest",
        )  # fmt: skip
        axes.set_title(f"{letter}  {name}, {shown} increments", loc="left")
        axes.set_xlabel("x [µm]")
        axes.grid(visible=False)
    row[0].set_ylabel("y [µm], a part of the contact")
    figure.colorbar(image, ax=list(row), label="pressure [GPa]", pad=0.02)


def _curve(axes: Axes, row: Mapping[int, list[float]], name: str, colour: str, style: str) -> None:
    at = sorted(row)
    mean, spread = np.array([statistics(row[n]) for n in at]).T
    axes.errorbar(
        at, mean, spread if spread.any() else None, color=colour, ls=style, marker="o", ms=3.5,
        capsize=2, label=name,
    )  # fmt: skip
