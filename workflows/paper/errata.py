"""Printed equations that are wrong, the right ones, and what the difference does."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import quad
from scipy.special import erf

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, house_style
from tribo import Grid, Material, Scene, contact_modulus
from tribo.analytic import hertz_line_half_width
from tribo.contact import ElasticHalfSpace
from tribo.types import Array

from .publication import DISK_DIAMETER, TABLE_4
from .recomputed import WORDS, Recomputation, texts
from .study import Study

_ELEMENTS, _WINDOW = 128, 456e-6  # along x, in the plane of the cylinder [m]
_TRACK = 0.34  # length of the wear track on the disk [m]; the paper prints none
_LOOPS = {  # by name: sign of the gap, whether the load's factor is inverse, iterations, look
    "corrected": (1.0, False, 8, BLACK, "-"),
    "Eq. (9) as printed": (-1.0, False, 8, VERMILION, "--"),
    "Eq. (23) as printed": (1.0, True, 2, BLUE, ":"),  # three more overflow
}


def errata(study: Study) -> Recomputation:
    """Report on printed equations that cannot be right, tried on the paper's smooth cylinder."""
    sweep = study.scene("table4")
    load = sweep.loads[-1]
    study.tell("the loop of Eqs. (9) to (23), as printed and corrected")
    x, half_width, pressures = _pressures(sweep.scene, load)
    element = x[1] - x[0]
    carried = {name: float(p.sum() * element / load) for name, p in pressures.items()}
    within = {
        name: float(p[np.abs(x) < half_width].sum() / p.sum()) for name, p in pressures.items()
    }
    heat = _heat_ratios(sweep.scene.disk)
    values = {
        "within": within["Eq. (9) as printed"],
        "within_right": within["corrected"],
        "iterations": _LOOPS["corrected"][2],
        "carried": carried["Eq. (23) as printed"],
        "few": _LOOPS["Eq. (23) as printed"][2],
        "heat": heat["outside the root"],
        "heat_under_root": heat["under the root"],
        "track": _TRACK,
        "track_ratio": _TRACK / TABLE_4.measured_width,
        "disk_diameter": 1e3 * DISK_DIAMETER,
        "rim_ratio": math.pi * DISK_DIAMETER / TABLE_4.measured_width,
    }
    columns = "iterations", "load / prescribed", "within Hertz's width"
    return Recomputation.from_values(
        "errata",
        values,
        verdicts=dict.fromkeys(WORDS["errata"]["findings"], False),
        table=texts(
            ("loop", *columns),
            [
                (name, f"{how[2]}", f"{carried[name]:.4g}", f"{100 * within[name]:.0f} %")
                for name, how in _LOOPS.items()
            ],
        ),
        data={"load_carried": carried, "load_within_hertz": within, "heat_ratio": heat},
        figure=_draw(x, half_width, pressures),
    )


def _pressures(scene: Scene, load: float) -> tuple[Array, float, dict[str, Array]]:
    """Places along x [m], Hertz's half-width [m], and loads per length by loop [N/m]."""
    radius, length = scene.pin.radius, float(scene.pin.length or math.nan)
    modulus = contact_modulus(scene.pin.material, scene.disk)
    grid = Grid((_ELEMENTS, 1), (_WINDOW / _ELEMENTS, length))
    solid, x = ElasticHalfSpace(grid, modulus), grid.coordinates(0)
    separation = x[:, None] ** 2 / (2 * radius)
    pressures = {
        name: length * _iterate(solid, separation, load, *how[:3])[:, 0]
        for name, how in _LOOPS.items()
    }
    return x, hertz_line_half_width(load / length, radius, modulus), pressures


def _iterate(
    solid: ElasticHalfSpace, h: Array, load: float, sign: float, inverse: bool, iterations: int
) -> Array:
    """Pressure after iterations of Eqs. (9) to (23), with the separation h.

    `sign` is that of the gap: 1 for u + h, and −1 for −u − h as printed. `inverse` is True for the
    printed factor that restores the load.
    """
    area = math.prod(solid.grid.spacing)
    p = np.full(h.shape, load / (area * h.size))
    t, delta, G_old = np.zeros(h.shape), 0.0, 1.0
    for _ in range(iterations):
        touching = p > 0
        g = sign * (solid(p) + h)
        g = g - g[touching].mean()
        G = float((g[touching] ** 2).sum())
        t = np.where(touching, g + delta * G / G_old * t, 0.0)
        G_old = G
        r = solid(t)
        r = r - r[touching].mean()
        tau = float((g[touching] * t[touching]).sum() / (r[touching] * t[touching]).sum())
        p = np.maximum(np.where(touching, p - tau * t, p), 0.0)
        overlap = (p == 0) & (g < 0)
        delta = 0.0 if overlap.any() else 1.0
        p = np.where(overlap, p - tau * g, p)
        carried = area * float(p.sum()) / load
        p = p * carried if inverse else p / carried
    return p


def _heat_ratios(steel: Material) -> dict[str, float]:
    """Steady rise in the middle of a square at rest by Eq. (29), over the exact one.

    Keys state where ρC_p is read: under the root, as printed, or outside.
    """
    side = 1e-6  # half of the square's [m]; the ratio does not depend on it
    # With s = side/(2 √κ ω), so that the range is finite where the integrand is large.
    integral, _ = quad(lambda s: float((2 * erf(s)) ** 2 / s**2), 0.0, np.inf)
    kappa, heat_capacity = steel.thermal_diffusivity, steel.density * steel.specific_heat
    over_omega = integral * side / (2 * math.sqrt(kappa))
    exact = 4 * side * math.log(1 + math.sqrt(2)) / (math.pi * steel.thermal_conductivity)
    denominators = {
        "under the root": 4 * math.sqrt(math.pi * kappa * heat_capacity),
        "outside the root": 4 * heat_capacity * math.sqrt(math.pi * kappa),
    }
    return {name: float(over_omega / x / exact) for name, x in denominators.items()}


@house_style
def _draw(x: Array, half_width: float, pressures: dict[str, Array]) -> Figure:
    figure = Figure(figsize=(7.4, 4.2))
    axes = figure.subplots()
    for name, load in pressures.items():
        *_, colour, style = _LOOPS[name]
        axes.plot(1e6 * x, load / load.sum(), color=colour, ls=style, label=name)
    for side in (-1, 1):
        axes.axvline(side * 1e6 * half_width, color=GREY, lw=0.9)
    axes.set(xlabel="x, along sliding [µm]", ylabel="pressure / sum of pressures")
    axes.set_title("pressure of a smooth cylinder by the loop", loc="left")
    axes.legend(loc="upper center")
    return figure
