"""The figure of a mesh: velocities, pressure, temperature and film along the path of contact."""

from __future__ import annotations

from matplotlib.figure import Figure

from pipeline.figures.style import (
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    VERMILION,
    Picture,
    as_text,
    house_style,
)
from pipeline.gears.contact import Mesh
from pipeline.quantities import shown_in


@house_style
def draw_mesh(mesh: Mesh) -> Figure:
    """Draw the contact along the path of contact, with the pinion's tip on the right.

    Parameters
    ----------
    mesh : Mesh
        The mesh to draw, from `pipeline.gears.mesh`.
    """
    at = [shown_in(place.position, "mm") for place in mesh.places]
    figure = Picture(figsize=(7.2, 7.6))
    speeds, loads, heat = figure.subplots(3, sharex=True)
    figure.suptitle(as_text(mesh.pair.title))
    for axes, name, unit, colour, label in (
        (speeds, "rolling_1", "m/s", BLUE, "pinion's flank"),
        (speeds, "rolling_2", "m/s", GREEN, "wheel's flank"),
        (speeds, "sliding", "m/s", VERMILION, "sliding"),
        (loads, "pressure", "GPa", BLUE, None),
        (heat, "temperature", "°C", VERMILION, "bulk and flash, smooth flanks"),
    ):
        values = [shown_in(getattr(place, name), unit) for place in mesh.places]
        axes.plot(at, values, color=colour, label=label)
    speeds.axhline(0.0, color=GREY, linewidth=0.8)
    loads.set_ylim(bottom=0)
    heat.axhline(shown_in(mesh.duty.bulk, "°C"), color=GREY, linestyle="--", label="bulk")
    if mesh.pair.critical is not None:
        heat.axhline(shown_in(mesh.pair.critical, "°C"), color=PURPLE, ls="-.", label="critical")
    speeds.set_ylabel("velocity [m/s]")
    loads.set_ylabel("highest pressure [GPa]", color=BLUE)
    heat.set_ylabel("temperature [°C]")
    heat.set_xlabel("place on the path of contact, from the pitch point [mm]")
    films = [place.film_parameter for place in mesh.places]
    if None not in films:
        film = loads.twinx()
        film.plot(at, films, color=GREEN, linestyle=":")
        film.set_ylabel("film parameter Λ, dotted", color=GREEN)
        film.set_ylim(0, 1.6 * max(film.get_ylim()))  # keeps it apart from the pressure
        film.grid(visible=False)
    speeds.legend()
    heat.legend()
    for x, place in zip(at, mesh.places, strict=True):
        if place.letter:
            for axes in (speeds, loads, heat):
                axes.axvline(x, color=GREY, linewidth=0.6, linestyle=":")
            where = speeds.get_xaxis_transform()
            speeds.text(x, 1.02, place.letter, transform=where, ha="center")
    return figure
