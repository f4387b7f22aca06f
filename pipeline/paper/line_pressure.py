"""Fig. 4: the pressure under a smooth cylinder, without periodicity and with two kinds of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, in_house_style
from pipeline.paper.printed import CYLINDER_HALF_WIDTH, CYLINDER_PEAK_PRESSURE
from pipeline.paper.report import Finding, Report, Table
from pipeline.paper.study import Study
from pipeline.sweep.model import Sweep
from tribo import Cylinder, Grid, contact_modulus, simulate
from tribo.analytic import hertz_line_half_width, hertz_line_peak_pressure, hertz_pressure
from tribo.types import Array


def fig4(study: Study) -> Report:
    """Pressure of a cylinder on a patch with free ends, with its nearest images, with all."""
    sweep = study.scene("fig4")
    if not isinstance(sweep.pin, Cylinder):
        raise TypeError("Fig. 4 is about a cylinder")
    load = sweep.loads[-1]
    per_length = load / sweep.pin.length
    modulus = contact_modulus(sweep.pin.material, sweep.disk)
    peak = hertz_line_peak_pressure(per_length, sweep.pin.radius, modulus)
    half_width = hertz_line_half_width(per_length, sweep.pin.radius, modulus)

    grid = sweep.grid
    rows = sweep.pixels.shape[1] // sweep.fidelity.pixels_per_element
    x = grid.coordinates(0)
    y = Grid((grid.shape[0], rows), (1.0, sweep.pixels.size[1] / rows)).coordinates(1)
    free, nearest, exact = (
        np.broadcast_to(_pressure(_variant(sweep, *variant), load), (len(x), rows))
        for variant in ((False, "periodic"), (True, "nearest-image"), (True, "periodic"))
    )
    middle, centre = rows // 2, len(x) // 2
    end, inside = float(free[:, 0].max()), float(free[centre, middle])
    over, short = float(nearest.max() / peak - 1), float(exact.max() / peak - 1)

    def of(field: Array) -> tuple[str, str, str]:
        return (
            f"{field[centre, middle] / 1e9:.4f}",
            f"{field.max() / 1e9:.4f}",
            f"{100 * (field[centre, middle] / peak - 1):+.3f} %",
        )

    table = Table(
        ("", "p at the centre [GPa]", "highest p [GPa]", "centre against Hertz"),
        (
            ("printed (Hertz)", f"{CYLINDER_PEAK_PRESSURE / 1e9:.2f}", "", ""),
            ("Hertz", f"{peak / 1e9:.4f}", f"{peak / 1e9:.4f}", ""),
            ("a: free ends", *of(free)),
            ("b: nearest images", *of(nearest)),
            ("all images", *of(exact)),
        ),
    )
    findings = (
        Finding(
            f"p0 of {CYLINDER_PEAK_PRESSURE / 1e9:.2f} GPa and half-width of "
            f"{CYLINDER_HALF_WIDTH * 1e3:.2f} mm",
            f"{peak / 1e9:.4f} GPa and {half_width * 1e3:.4f} mm by Hertz at "
            f"{per_length / 1e3:.1f} N/mm",
            abs(peak - CYLINDER_PEAK_PRESSURE) < 0.005e9
            and abs(half_width - CYLINDER_HALF_WIDTH) < 0.005e-3,
        ),
        Finding(
            "punch peaks at both ends without compensation",
            f"{end / 1e9:.2f} GPa there, {end / inside:.1f} times that in the middle",
            end > 1.5 * inside,
            "The peak is singular: its height is that of the element, and grows on finer ones.",
        ),
        Finding(
            "with compensation in good agreement with Hertz",
            f"p0 is {100 * over:+.2f} %",
            abs(over) < 0.02,
            "The images farther away, which it leaves out, press the middle of the contact down "
            f"more than its edges; with all of them p0 is {100 * short:+.3f} %.",
        ),
    )
    return Report(
        name="fig4",
        title="pressure under a cylinder of radius 8 mm, on a patch of 0.456 mm",
        table=table,
        findings=findings,
        notes=("The load is not printed; 222.2 N/mm gives the printed 1.01 GPa.",),
        data={
            "hertz_peak_pressure": peak,
            "hertz_half_width": half_width,
            "peak_pressure": {
                "free": float(free.max()),
                "nearest_image": float(nearest.max()),
                "periodic": float(exact.max()),
            },
            "centre_pressure_free": inside,
            "overestimate": {"nearest_image": over, "periodic": short},
        },
        figure=_draw(x, y, free, nearest, exact, peak, half_width),
    )


def _variant(sweep: Sweep, periodic: bool, kernel: Literal["periodic", "nearest-image"]) -> Sweep:
    return replace(
        sweep,
        pixels=replace(sweep.pixels, periodic=(False, periodic)),
        fidelity=replace(sweep.fidelity, kernel=kernel),
    )


def _pressure(scene: Sweep, load: float) -> Array:
    *_, state = simulate(scene, load, scene.velocities[-1])
    return state.pressure


@in_house_style
def _draw(
    x: Array, y: Array, free: Array, nearest: Array, exact: Array, peak: float, half_width: float
) -> Figure:
    figure = Figure(figsize=(8.4, 6.6))
    (left, right), (across, along) = figure.subplots(2, 2, height_ratios=(1.15, 1))
    um = 1e6
    colours = colormaps["viridis_r"].resampled(32)
    for axes, field, title in (
        (left, free, "a  free ends"),
        (right, nearest, "b  compensated by the nearest images"),
    ):
        image = axes.pcolormesh(
            um * x, um * y, field.T / 1e9, cmap=colours, vmin=0, vmax=1.6, rasterized=True
        )
        axes.set_title(title, loc="left")
        axes.set_xlabel("x, along sliding [µm]")
        axes.set_ylabel("y [µm]")
        axes.grid(visible=False)
    figure.colorbar(image, ax=[left, right], label="pressure [GPa]", extend="max", pad=0.02)

    hertz = hertz_pressure(x, half_width, peak) / 1e9
    middle, centre = len(y) // 2, len(x) // 2
    for field, colour, style, name in (
        (free, VERMILION, "-", "free ends"),
        (nearest, BLUE, "-", "nearest images"),
        (exact, BLACK, "-", "all images"),
    ):
        across.plot(um * x, field[:, middle] / 1e9, color=colour, ls=style, label=name)
        along.plot(um * y, field[centre] / 1e9, color=colour, ls=style)
    across.plot(um * x, hertz, color=GREY, ls=":", lw=2.6, label="Hertz")
    along.axhline(peak / 1e9, color=GREY, ls=":", lw=2.6)
    across.set_title("across the contact, in the middle", loc="left")
    across.set_xlabel("x [µm]")
    across.set_ylabel("pressure [GPa]")
    across.set_ylim(0, 1.45)
    across.legend(loc="upper center", ncols=2)
    along.set_title("along the cylinder, at x = 0", loc="left")
    along.set_xlabel("y [µm]")
    along.set_ylim(0.8, 1.6)
    return figure
