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
from workflows.paper.printed import CYLINDER_HALF_WIDTH, CYLINDER_PEAK_PRESSURE
from workflows.paper.report import Finding, Report, Table
from workflows.paper.study import Study

_UM = 1e6  # in a metre


@dataclass(frozen=True, slots=True)
class _Computed:
    """Pressures [Pa] by element along x and y, and what Hertz gives for an endless cylinder."""

    load: float  # on the cylinder [N]
    length: float  # of the cylinder [m]
    peak: float  # by Hertz [Pa]
    half_width: float  # by Hertz [m]
    x: Array  # of the elements' centres [m]
    y: Array  # of the elements' centres [m]
    free: Array  # with free ends
    nearest: Array  # with the nearest images
    exact: Array  # with all images

    @property
    def load_per_length(self) -> float:
        """Load per length of the cylinder [N/m]."""
        return self.load / self.length

    @property
    def centre(self) -> tuple[int, int]:
        """Indices of the element in the middle."""
        return len(self.x) // 2, len(self.y) // 2

    @property
    def free_end(self) -> float:
        """Highest pressure at a free end [Pa]."""
        return float(self.free[:, 0].max())

    @property
    def free_centre(self) -> float:
        """Pressure in the middle of the patch with free ends [Pa]."""
        return float(self.free[self.centre])

    def excess(self, pressure: Array) -> float:
        """Highest pressure above that of Hertz, relative."""
        return float(pressure.max() / self.peak - 1)


def fig4(study: Study) -> Report:
    """Pressure of a cylinder on a patch with free ends, with its nearest images, with all."""
    found = _computed(study.scene("fig4"))
    return Report(
        name="fig4",
        title="pressure under a cylinder of radius 8 mm, on a patch of 0.456 mm",
        table=_table(found),
        findings=(_on_hertz(found), _on_ends(found), _on_compensation(found)),
        notes=(
            f"The load is not printed for this figure. Taken is the highest of the tests on the "
            f"length of their pin, {found.load:g} N on {1e3 * found.length:g} mm; with it the "
            "printed numbers are those of Hertz, rounded.",
        ),
        data={
            "hertz_peak_pressure": found.peak,
            "hertz_half_width": found.half_width,
            "peak_pressure": {
                "free": float(found.free.max()),
                "nearest_image": float(found.nearest.max()),
                "periodic": float(found.exact.max()),
            },
            "centre_pressure_free": found.free_centre,
            "overestimate": {
                "nearest_image": found.excess(found.nearest),
                "periodic": found.excess(found.exact),
            },
        },
        figure=_draw(found),
    )


def _computed(sweep: Sweep) -> _Computed:
    if not isinstance(sweep.pin, Cylinder):
        raise InputError(f'the scene {sweep.name} must have a pin of shape "cylinder"')
    load = sweep.loads[-1]
    per_length = load / sweep.pin.length
    modulus = contact_modulus(sweep.pin.material, sweep.disk)
    grid = sweep.grid
    rows = sweep.pixels.shape[1] // sweep.fidelity.pixels_per_element
    x = grid.coordinates(0)
    y = Grid((grid.shape[0], rows), (1.0, sweep.pixels.size[1] / rows)).coordinates(1)
    free, nearest, exact = (
        np.broadcast_to(_pressure(_variant(sweep, *variant), load), (len(x), rows))
        for variant in ((False, "periodic"), (True, "nearest-image"), (True, "periodic"))
    )
    return _Computed(
        load=load,
        length=sweep.pin.length,
        peak=hertz_line_peak_pressure(per_length, sweep.pin.radius, modulus),
        half_width=hertz_line_half_width(per_length, sweep.pin.radius, modulus),
        x=x,
        y=y,
        free=free,
        nearest=nearest,
        exact=exact,
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


def _table(found: _Computed) -> Table:
    def of(pressure: Array) -> tuple[str, str, str]:
        centre = pressure[found.centre]
        return (
            f"{centre / 1e9:.4f}",
            f"{pressure.max() / 1e9:.4f}",
            f"{100 * (centre / found.peak - 1):+.3f} %",
        )

    hertz = f"{found.peak / 1e9:.4f}"
    return Table(
        ("", "p at the centre [GPa]", "highest p [GPa]", "centre against Hertz"),
        (
            ("printed (Hertz)", f"{CYLINDER_PEAK_PRESSURE / 1e9:.2f}", "", ""),
            ("Hertz", hertz, hertz, ""),
            ("a: free ends", *of(found.free)),
            ("b: nearest images", *of(found.nearest)),
            ("all images", *of(found.exact)),
        ),
    )


def _on_hertz(found: _Computed) -> Finding:
    return Finding(
        f"p0 of {CYLINDER_PEAK_PRESSURE / 1e9:.2f} GPa and half-width of "
        f"{CYLINDER_HALF_WIDTH * 1e3:.2f} mm",
        f"{found.peak / 1e9:.3f} GPa and {found.half_width * 1e3:.4f} mm by Hertz at "
        f"{found.load_per_length / 1e3:.1f} N/mm",
        abs(found.peak - CYLINDER_PEAK_PRESSURE) < 0.005e9
        and abs(found.half_width - CYLINDER_HALF_WIDTH) < 0.005e-3,
    )


def _on_ends(found: _Computed) -> Finding:
    end, inside = found.free_end, found.free_centre
    return Finding(
        "punch peaks at both ends without compensation",
        f"{end / 1e9:.2f} GPa there, {end / inside:.1f} times that in the middle",
        end > 1.5 * inside,
        "The peak is singular: its height is that of the element, and grows on finer ones.",
    )


def _on_compensation(found: _Computed) -> Finding:
    nearest, exact = found.excess(found.nearest), found.excess(found.exact)
    return Finding(
        "with compensation in good agreement with Hertz",
        f"p0 is {100 * nearest:+.2f} %",
        abs(nearest) < 0.02,
        "The images farther away, which it leaves out, press the middle of the contact down "
        f"more than its edges; with all of them p0 is {100 * exact:+.3f} %.",
    )


@in_house_style
def _draw(found: _Computed) -> Figure:
    figure = Figure(figsize=(8.4, 6.6))
    fields, (across, along) = figure.subplots(2, 2, height_ratios=(1.15, 1))
    _draw_fields(figure, list(fields), found)
    _draw_sections(across, along, found)
    return figure


def _draw_fields(figure: Figure, row: list[Axes], found: _Computed) -> None:
    """Draw the pressure on the patch, on one scale."""
    colours = colormaps["viridis_r"].resampled(32)
    for axes, field, title in zip(
        row,
        (found.free, found.nearest),
        ("a  free ends", "b  compensated by the nearest images"),
        strict=True,
    ):
        image = axes.pcolormesh(
            _UM * found.x, _UM * found.y, field.T / 1e9,
            cmap=colours, vmin=0, vmax=1.6, rasterized=True,
        )  # fmt: skip
        axes.set_title(title, loc="left")
        axes.set_xlabel("x, along sliding [µm]")
        axes.set_ylabel("y [µm]")
        axes.grid(visible=False)
    figure.colorbar(image, ax=row, label="pressure [GPa]", extend="max", pad=0.02)


def _draw_sections(across: Axes, along: Axes, found: _Computed) -> None:
    """Draw the pressure across the contact and along the cylinder beside that of Hertz."""
    hertz = hertz_pressure(found.x, found.half_width, found.peak) / 1e9
    centre, middle = found.centre
    for field, colour, name in (
        (found.free, VERMILION, "free ends"),
        (found.nearest, BLUE, "nearest images"),
        (found.exact, BLACK, "all images"),
    ):
        across.plot(_UM * found.x, field[:, middle] / 1e9, color=colour, ls="-", label=name)
        along.plot(_UM * found.y, field[centre] / 1e9, color=colour, ls="-")
    across.plot(_UM * found.x, hertz, color=GREY, ls=":", lw=2.6, label="Hertz")
    along.axhline(found.peak / 1e9, color=GREY, ls=":", lw=2.6)
    across.set_title("across the contact, in the middle", loc="left")
    across.set_xlabel("x [µm]")
    across.set_ylabel("pressure [GPa]")
    across.set_ylim(0, 1.45)
    across.legend(loc="upper center", ncols=2)
    along.set_title("along the cylinder, at x = 0", loc="left")
    along.set_xlabel("y [µm]")
    along.set_ylim(0.8, 1.6)
