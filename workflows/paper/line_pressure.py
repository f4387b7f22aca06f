"""Fig. 4: the pressure under a smooth cylinder, without periodicity and with two kinds of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, in_house_style
from pipeline.sweep.model import Sweep
from tribo import Cylinder, Grid, InputError, contact_modulus, simulate
from tribo.analytic import hertz_line_half_width, hertz_line_peak_pressure, hertz_pressure
from tribo.types import Array
from workflows.paper.publication import CYLINDER_HALF_WIDTH, CYLINDER_PEAK_PRESSURE
from workflows.paper.report import Report, Table
from workflows.paper.study import Study

_UM = 1e6  # in a metre


@dataclass(frozen=True, slots=True)
class _Pressures:
    """Pressures [Pa] by element along x and y, and those of Hertz for an endless cylinder."""

    peak: float  # by Hertz [Pa]
    half_width: float  # by Hertz [m]
    x: Array  # of the elements' centres [m]
    y: Array  # of the elements' centres [m]
    free: Array  # with free ends
    nearest: Array  # with the nearest images
    exact: Array  # with all images

    @property
    def centre(self) -> tuple[int, int]:
        """Indices of the element in the middle."""
        return len(self.x) // 2, len(self.y) // 2

    def excess(self, pressure: Array) -> float:
        """Highest pressure above that of Hertz, relative."""
        return float(pressure.max() / self.peak - 1)


def fig4(study: Study) -> Report:
    """Pressure of a cylinder on a patch with free ends, with its nearest images, with all."""
    sweep = study.scene("fig4")
    if not isinstance(sweep.pin, Cylinder):
        raise InputError(f'the scene {sweep.name} must have a pin of shape "cylinder"')
    per_length = sweep.loads[-1] / sweep.pin.length
    fields = _pressures(sweep, sweep.pin, per_length)
    inside, end = float(fields.free[fields.centre]), float(fields.free[:, 0].max())
    nearest, exact = fields.excess(fields.nearest), fields.excess(fields.exact)
    values = {
        "load": sweep.loads[-1],
        "length": 1e3 * sweep.pin.length,
        "printed_peak": CYLINDER_PEAK_PRESSURE / 1e9,
        "printed_half_width": CYLINDER_HALF_WIDTH * 1e3,
        "peak": fields.peak / 1e9,
        "half_width": fields.half_width * 1e3,
        "load_per_length": per_length / 1e3,
        "end": end / 1e9,
        "ratio": end / inside,
        "nearest": nearest,
        "exact": exact,
    }
    return Report.of(
        "fig4",
        values,
        verdicts={
            "hertz": abs(fields.peak - CYLINDER_PEAK_PRESSURE) < 0.005e9
            and abs(fields.half_width - CYLINDER_HALF_WIDTH) < 0.005e-3,
            "ends": end > 1.5 * inside,
            "compensation": abs(nearest) < 0.02,
        },
        table=_table(fields),
        data={
            "hertz_peak_pressure": fields.peak,
            "hertz_half_width": fields.half_width,
            "peak_pressure": {
                "free": float(fields.free.max()),
                "nearest_image": float(fields.nearest.max()),
                "periodic": float(fields.exact.max()),
            },
            "centre_pressure_free": inside,
            "overestimate": {"nearest_image": nearest, "periodic": exact},
        },
        figure=_draw(fields),
    )


def _pressures(sweep: Sweep, pin: Cylinder, per_length: float) -> _Pressures:
    modulus = contact_modulus(pin.material, sweep.disk)
    rows = sweep.pixels.shape[1] // sweep.fidelity.pixels_per_element
    x = sweep.grid.coordinates(0)
    y = Grid((len(x), rows), (1.0, sweep.pixels.size[1] / rows)).coordinates(1)
    free, nearest, exact = (
        np.broadcast_to(_pressure(sweep, *variant), (len(x), rows))
        for variant in ((False, "periodic"), (True, "nearest-image"), (True, "periodic"))
    )
    return _Pressures(
        hertz_line_peak_pressure(per_length, pin.radius, modulus),
        hertz_line_half_width(per_length, pin.radius, modulus),
        x, y, free, nearest, exact,
    )  # fmt: skip


def _pressure(sweep: Sweep, periodic: bool, kernel: Literal["periodic", "nearest-image"]) -> Array:
    scene = replace(
        sweep,
        pixels=replace(sweep.pixels, periodic=(False, periodic)),
        fidelity=replace(sweep.fidelity, kernel=kernel),
    )
    *_, state = simulate(scene, scene.loads[-1], scene.velocities[-1])
    return state.pressure


def _table(fields: _Pressures) -> Table:
    def of(pressure: Array) -> tuple[str, str, str]:
        centre = pressure[fields.centre]
        return (
            f"{centre / 1e9:.4f}",
            f"{pressure.max() / 1e9:.4f}",
            f"{100 * (centre / fields.peak - 1):+.3f} %",
        )

    hertz = f"{fields.peak / 1e9:.4f}"
    return Table(
        ("", "p at the centre [GPa]", "highest p [GPa]", "centre against Hertz"),
        (
            ("printed (Hertz)", f"{CYLINDER_PEAK_PRESSURE / 1e9:.2f}", "", ""),
            ("Hertz", hertz, hertz, ""),
            ("a: free ends", *of(fields.free)),
            ("b: nearest images", *of(fields.nearest)),
            ("all images", *of(fields.exact)),
        ),
    )


@in_house_style
def _draw(fields: _Pressures) -> Figure:
    figure = Figure(figsize=(8.4, 6.6))
    upper, (across, along) = figure.subplots(2, 2, height_ratios=(1.15, 1))
    _draw_fields(figure, list(upper), fields)
    _draw_sections(across, along, fields)
    return figure


def _draw_fields(figure: Figure, row: list[Axes], fields: _Pressures) -> None:
    """Draw the pressure on the patch, on one scale."""
    colours = colormaps["viridis_r"].resampled(32)
    titles = ("a  free ends", "b  compensated by the nearest images")
    for axes, field, title in zip(row, (fields.free, fields.nearest), titles, strict=True):
        image = axes.pcolormesh(
            _UM * fields.x, _UM * fields.y, field.T / 1e9,
            cmap=colours, vmin=0, vmax=1.6, rasterized=True,
        )  # fmt: skip
        axes.set_title(title, loc="left")
        axes.set(xlabel="x, along sliding [µm]", ylabel="y [µm]")
        axes.grid(visible=False)
    figure.colorbar(image, ax=row, label="pressure [GPa]", extend="max", pad=0.02)


def _draw_sections(across: Axes, along: Axes, fields: _Pressures) -> None:
    """Draw the pressure across the contact and along the cylinder beside that of Hertz."""
    hertz = hertz_pressure(fields.x, fields.half_width, fields.peak) / 1e9
    centre, middle = fields.centre
    for field, colour, name in (
        (fields.free, VERMILION, "free ends"),
        (fields.nearest, BLUE, "nearest images"),
        (fields.exact, BLACK, "all images"),
    ):
        across.plot(_UM * fields.x, field[:, middle] / 1e9, color=colour, ls="-", label=name)
        along.plot(_UM * fields.y, field[centre] / 1e9, color=colour, ls="-")
    across.plot(_UM * fields.x, hertz, color=GREY, ls=":", lw=2.6, label="Hertz")
    along.axhline(fields.peak / 1e9, color=GREY, ls=":", lw=2.6)
    across.set_title("across the contact, in the middle", loc="left")
    across.set(xlabel="x [µm]", ylabel="pressure [GPa]", ylim=(0, 1.45))
    across.legend(loc="upper center", ncols=2)
    along.set_title("along the cylinder, at x = 0", loc="left")
    along.set(xlabel="y [µm]", ylim=(0.8, 1.6))
