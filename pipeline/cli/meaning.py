"""Meaning of a scene in words: the lines that ``irg check`` prints first."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.sweep.facts import Facts, Span
from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Sweep
from pipeline.sweep.own import own_laws
from pipeline.sweep.surface import SurfaceFacts
from tribo import lubrication_regime

_LEVEL = 1e-6  # of Rq, below which a tilt or a mean height is that of rounding


def meaning(sweep: Sweep, facts: Facts) -> Iterator[str]:
    """Say what a scene means, a line for each subject."""
    x, y = facts.window
    worn = "worn" if facts.wear_depth else "unworn"
    rough = "rough" if facts.surface else "smooth"
    yield (
        f"  contact  Hertz: {_text(facts.hertz_pressure, 1e-9)} GPa, half-width "
        f"{_text(facts.hertz_half_width, 1e6)} µm; {worn} and {rough}: "
        f"{_text(facts.contact_width, 1e6)} µm wide at the end"
    )
    yield f"  window   {1e6 * x:.4g} × {1e6 * y:.4g} µm, {_share(facts)}"
    surface = _surface(facts.surface) if facts.surface else "smooth"
    is_own = "roughness" in own_laws(sweep)
    yield f"  surface  {surface.replace('measured', 'own law') if is_own else surface}"
    yield (
        f"  motion   {_text(facts.duration)} s and {_text(facts.sliding_distance)} m until the end"
        f"{_both_moving(facts)}"
    )
    yield from _film(sweep)
    u = "V" if facts.disk_velocity is None else "of the disk u"
    depth = f"{_text(facts.wear_depth, 1e6)} µm deep at the end" if facts.wear_depth else "none"
    yield f"  wear     {depth}"
    yield (
        f"  heat     Péclet number {_text(facts.peclet_number)}: {u} a/(2 κ), a the half-width of "
        "Hertz"
        if sweep.friction_heat
        else "  heat     none, since there is no friction"
    )
    laws = own_laws(sweep)
    if sweep.conditions.criterion_hash:
        reference = {"law": sweep.conditions.criterion, "parameters": {}}
        laws["criterion"] = reference | {"hash": sweep.conditions.criterion_hash}
    for entry, law in laws.items():
        named = "".join(f", {name} = {value}" for name, value in law["parameters"].items())
        yield f"  own law  {entry}: {law['law']}{named}, hash {law['hash'][:8]}"
    if sweep.conditions.corrections:
        yield f"  besides  {sweep.conditions.corrections.worded}"


def _both_moving(facts: Facts) -> str:
    """Say how fast both bodies move; nothing where the pin is at rest."""
    if facts.pin_velocity is None or facts.disk_velocity is None or facts.pin_turns is None:
        return ""
    return (
        f"; the pin rolls at {_text(facts.pin_velocity)} m/s, {_text(facts.pin_turns)} turns, the "
        f"disk at {_text(facts.disk_velocity)} m/s"
    )


def _film(sweep: Sweep) -> Iterator[str]:
    """Say which film the oil would build, or what is missing to tell; nothing without an oil."""
    if sweep.oil is None:
        return
    bulk = sweep.conditions.mean_bulk_temperature
    yield f"  oil      {1e3 * sweep.oil.viscosity(bulk):.3g} mPa s at the bulk temperature"
    lubrication = Lubrication.of(sweep)
    if lubrication is None:
        has_pressure_coefficient = sweep.oil.pressure_coefficients is not None
        missing = "a rough disk" if has_pressure_coefficient else "pressure_viscosity_coefficient"
        yield f"  film     not known without {missing}"
        return
    corners = np.meshgrid(sweep.loads, sweep.velocities)
    span = Span.of(lubrication.film_parameter(*corners, bulk))
    regimes = dict.fromkeys(lubrication_regime(value) for value in span)
    yield f"  film     Λ {_text(span)}: {' to '.join(regimes)}"


def library_lines(sweep: Sweep) -> Iterator[str]:
    """Say what was taken from the library, a line for each table and source."""
    taken: dict[tuple[str, str], list[str]] = {}
    for key, value, source in sweep.library:
        table, _, name = key.rpartition(".")
        taken.setdefault((table, source), []).append(f"{name.replace('_', ' ')} {value}")
    for (table, source), values in taken.items():
        yield f"  library  {table}: {', '.join(values)}"
        yield f"           from {source}"


def _share(facts: Facts) -> str:
    if facts.greatest_load == float("inf"):
        return "elastic at any load"
    kilonewtons = 1e-3 * facts.greatest_load
    return f"carries at most {kilonewtons:.3g} kN on the pin, all of it at the hardness"


def _surface(surface: SurfaceFacts) -> str:
    """Describe a rough surface."""
    lay = "no lay" if surface.lay is None else f"grooves at {surface.lay:.0f}° to sliding"
    heights = f"Ra {1e6 * surface.ra:.3g} µm, Rq {1e6 * surface.rq:.3g} µm, {lay}"
    if not surface.measured:
        return f"random: {heights}"
    places = (surface.mean_height, *surface.rise)
    if all(abs(place) < _LEVEL * surface.rq for place in places):
        return f"measured: {heights}; level"
    mean, x, y = (1e6 * place for place in places)
    return (
        f"measured: {heights}; mean plane at {mean:.3g} µm, rising by "
        f"{x:.3g} µm along x and {y:.3g} µm along y over the window"
    )


def _text(span: Span, factor: float = 1.0) -> str:
    """Write a span, or the one value that it has."""
    low, high = (f"{factor * value:.3g}" for value in span)
    return low if low == high else f"{low} to {high}"
