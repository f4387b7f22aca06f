"""The figure of a mesh: velocities, pressure and share, temperature and film, by the place."""

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
    celsius,
    house_style,
    label_ends,
)
from pipeline.gears.contact import Mesh


@house_style
def draw_mesh(mesh: Mesh) -> Figure:
    """Draw the contact along the path of contact, the pinion's tip to the right.

    Parameters
    ----------
    mesh : Mesh
        Places of `pipeline.gears.mesh`.
    """
    places = mesh.places
    at = [1e3 * place.position for place in places]
    figure = Picture(figsize=(7.2, 7.6))
    speeds, loads, heat = figure.subplots(3, sharex=True)
    figure.suptitle(as_text(mesh.pair.title))
    speeds.plot(at, [place.rolling_1 for place in places], color=BLUE, label="pinion's flank")
    speeds.plot(at, [place.rolling_2 for place in places], color=GREEN, label="wheel's flank")
    speeds.plot(at, [place.sliding for place in places], color=VERMILION, label="sliding")
    speeds.set_ylabel("velocity [m/s]")
    speeds.axhline(0.0, color=GREY, linewidth=0.8)
    loads.plot(at, [1e-9 * place.pressure for place in places], color=BLUE)
    loads.set_ylabel("highest pressure [GPa]", color=BLUE)
    loads.set_ylim(bottom=0)
    heat.plot(
        at, [celsius(place.temperature) for place in places], color=VERMILION,
        label="bulk and flash,\nsmooth flanks",
    )  # fmt: skip
    heat.axhline(celsius(mesh.duty.bulk), color=GREY, linestyle="--", label="bulk")
    if mesh.pair.critical is not None:
        heat.axhline(celsius(mesh.pair.critical), color=PURPLE, linestyle="-.", label="critical")
    heat.set_ylabel("temperature [°C]")
    heat.set_xlabel("place on the path of contact, from the pitch point [mm]")
    parameters = [place.film_parameter for place in places]
    if None not in parameters:
        film = loads.twinx()
        film.plot(at, parameters, color=GREEN, linestyle=":")
        film.set_ylabel("film parameter Λ, dotted", color=GREEN)
        film.set_ylim(0, 1.6 * max(film.get_ylim()))  # apart from the pressure
        film.grid(visible=False)
    for axes in (speeds, heat):
        label_ends(axes)
    for place in places:
        if place.letter:
            for axes in (speeds, loads, heat):
                axes.axvline(1e3 * place.position, color=GREY, linewidth=0.6, linestyle=":")
            where = speeds.get_xaxis_transform()
            speeds.text(1e3 * place.position, 1.02, place.letter, transform=where, ha="center")
    return figure
