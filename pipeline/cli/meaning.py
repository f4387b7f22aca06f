"""What a scene means, in words: the lines that ``irg check`` prints first."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.sweep.facts import Facts, Span, SurfaceFacts
from pipeline.sweep.model import Sweep


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
    yield f"  surface  {_surface(facts.surface) if facts.surface else 'smooth'}"
    yield (
        f"  motion   {_text(facts.duration)} s and {_text(facts.sliding_distance)} m until the end"
    )
    depth = f"{_text(facts.wear_depth, 1e6)} µm deep at the end" if facts.wear_depth else "none"
    yield f"  wear     {depth}"
    yield (
        f"  heat     Péclet number {_text(facts.peclet_number)}: V a/(2 κ), a the half-width of "
        "Hertz"
        if sweep.friction_heat
        else "  heat     none, since there is no friction"
    )


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
    x, y = (1e6 * rise for rise in surface.rise)
    return (
        f"measured: {heights}; mean plane at {1e6 * surface.mean_height:.3g} µm, rising by "
        f"{x:.3g} µm along x and {y:.3g} µm along y over the window"
    )


def _text(span: Span, factor: float = 1.0) -> str:
    """Write a span, or the one value that it has."""
    low, high = (f"{factor * value:.3g}" for value in span)
    return low if low == high else f"{low} to {high}"
