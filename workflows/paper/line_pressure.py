"""Fig. 4: the pressure under a smooth cylinder, without periodicity and with two kinds of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, house_style
from tribo import Cylinder, Grid, InputError, contact_modulus
from tribo.analytic import hertz_line_half_width, hertz_line_peak_pressure, hertz_pressure
from tribo.contact import ElasticHalfSpace, ElasticKernel, solve_contact
from tribo.types import Array

from .publication import CYLINDER_HALF_WIDTH, CYLINDER_PEAK_PRESSURE
from .recomputed import Recomputation, cells, texts
from .study import Study

_LOOKS = {
    "free": ("a: free ends", VERMILION),
    "nearest_image": ("b: nearest images", BLUE),
    "periodic": ("all images", BLACK),
}


def fig4(study: Study) -> Recomputation:
    """Report on a cylinder's pressure on a window: free ends, nearest images, all images."""
    sweep = study.scene("fig4")
    pin = sweep.scene.pin
    if not isinstance(pin, Cylinder):
        raise InputError(f'the scene {sweep.name} must have a pin of shape "cylinder"')
    load_per_length = sweep.loads[-1] / pin.length
    hertz = load_per_length, pin.radius, contact_modulus(pin.material, sweep.scene.disk)
    peak, half_width = hertz_line_peak_pressure(*hertz), hertz_line_half_width(*hertz)
    fields = {
        "free": _pressure(sweep, load_per_length, "periodic", False),
        "nearest_image": _pressure(sweep, load_per_length, "nearest-image"),
        "periodic": _pressure(sweep, load_per_length, "periodic"),
    }
    middle = {name: _middle(field) for name, field in fields.items()}
    highest = {name: float(field.max()) for name, field in fields.items()}
    over = {name: highest[name] / peak - 1 for name in ("nearest_image", "periodic")}
    end = float(fields["free"][:, 0].max())
    values = {
        "load": sweep.loads[-1],
        "length": 1e3 * pin.length,
        "printed_peak": CYLINDER_PEAK_PRESSURE / 1e9,
        "printed_half_width": CYLINDER_HALF_WIDTH * 1e3,
        "peak": peak / 1e9,
        "half_width": half_width * 1e3,
        "load_per_length": load_per_length / 1e3,
        "end": end / 1e9,
        "ratio": end / middle["free"],
    }
    return Recomputation.from_values(
        "fig4",
        values,
        verdicts={
            "hertz": abs(peak - CYLINDER_PEAK_PRESSURE) < 0.005e9
            and abs(half_width - CYLINDER_HALF_WIDTH) < 0.005e-3,
            "ends": end > 1.5 * middle["free"],
            "compensation": abs(over["nearest_image"]) < 0.02,
        },
        table=texts(
            ("", "p at the centre [GPa]", "highest p [GPa]", "centre against Hertz"),
            (
                ("printed (Hertz)", f"{CYLINDER_PEAK_PRESSURE / 1e9:.2f}", "", ""),
                ("Hertz", f"{peak / 1e9:.4f}", f"{peak / 1e9:.4f}", ""),
                *(
                    (
                        label,
                        *cells((middle[name] / 1e9, highest[name] / 1e9), ".4f"),
                        f"{100 * (middle[name] / peak - 1):+.3f} %",
                    )
                    for name, (label, _) in _LOOKS.items()
                ),
            ),
        ),
        data={
            "hertz_peak_pressure": peak,
            "hertz_half_width": half_width,
            "peak_pressure": highest,
            "centre_pressure_free": middle["free"],
            "overestimate": over,
        },
        figure=_draw(sweep, fields, peak, half_width),
    )


def _pressure(
    sweep: Sweep, load_per_length: float, kernel: ElasticKernel, periodic: bool = True
) -> Array:
    """Contact pressure [Pa] of each element (x, y), with or without periodic images along y."""
    scene, block = sweep.scene, sweep.scene.fidelity.pixels_per_element
    (nx, ny), (dx, dy) = scene.pixels.shape, scene.pixels.spacing
    grid = Grid((nx // block, ny // block), (dx * block, dy * block), (False, periodic))
    solid = ElasticHalfSpace(grid, contact_modulus(scene.pin.material, scene.disk), kernel)
    load = load_per_length * grid.size[1]
    profile = scene.pin.profile(grid)
    return solve_contact(solid, profile, load, scene.hardness, scene.contact_tolerance).pressure


def _middle(field: Array) -> float:
    """Pressure in the middle of the window."""
    nx, ny = field.shape
    return float(field[nx // 2, ny // 2])


@house_style
def _draw(sweep: Sweep, fields: Mapping[str, Array], peak: float, half_width: float) -> Figure:
    figure = Figure(figsize=(8.4, 6.6))
    upper, (across, along) = figure.subplots(2, 2, height_ratios=(1.15, 1))
    nx, ny = fields["free"].shape
    x = sweep.scene.grid.coordinates(0)
    y = Grid((nx, ny), (1.0, sweep.scene.pixels.size[1] / ny)).coordinates(1)
    colours = colormaps["viridis_r"].resampled(32)
    titles = {"free": "a  free ends", "nearest_image": "b  compensated by the nearest images"}
    for axes, (name, title) in zip(upper, titles.items(), strict=True):
        image = axes.pcolormesh(
            1e6 * x, 1e6 * y, np.ma.masked_equal(fields[name].T / 1e9, 0.0),
            cmap=colours, vmin=0, vmax=1.6, rasterized=True,
        )  # fmt: skip
        axes.set_title(title, loc="left")
        axes.set(xlabel="x, along sliding [µm]", ylabel="y [µm]")
        axes.grid(visible=False)
    figure.colorbar(image, ax=list(upper), label="pressure [GPa]", extend="max", pad=0.02)
    for name, (label, colour) in _LOOKS.items():
        field, text = fields[name], label.split(": ")[-1]
        across.plot(1e6 * x, field[:, ny // 2] / 1e9, color=colour, ls="-", label=text)
        along.plot(1e6 * y, field[nx // 2] / 1e9, color=colour, ls="-")
    hertz = hertz_pressure(x, half_width, peak) / 1e9
    across.plot(1e6 * x, hertz, color=GREY, ls=":", lw=2.6, label="Hertz")
    along.axhline(peak / 1e9, color=GREY, ls=":", lw=2.6)
    across.set_title("c  across the contact, in the middle", loc="left")
    across.set(xlabel="x, along sliding [µm]", ylabel="pressure [GPa]", ylim=(0, 1.45))
    across.legend(loc="upper center", ncols=2)
    along.set_title("d  along the cylinder, at x = 0", loc="left")
    along.set(xlabel="y [µm]", ylabel="pressure [GPa]", ylim=(0.8, 1.6))
    return figure
