"""Write the scene of a gear pair: the rough, worn contact at each place of the mesh.

The pinion is the pin, a cylinder of the reduced radius. The wheel is the disk, which has the
roughness of both flanks. Both move through the contact. A point of the pinion's flank comes back
once a turn, so that its wear is spread over a track of 2π ρ1; likewise for the wheel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter
from typing import Any

from pipeline.gears.contact import Mesh, MeshPlace
from pipeline.gears.pair import UNTESTED
from pipeline.quantities import display
from pipeline.scene.document import as_toml
from tribo import InputError

_RAMP = 10.0  # [s] to reach the highest load
_ROOM = 1.2  # width of the window over the widest contact
_PEAKS = 3.0  # height of peaks in Rq, which widen the contact; as in irg check
_ALONG_Y = 240  # pixels along y
_MOST_PIXELS = 6000  # most pixels along x
_PIXELS_A_LENGTH = 4  # pixels in a correlation length of the roughness
_PIXELS_A_WIDTH = 80  # least pixels in the widest Hertz contact
_HEAD = (
    "# Places of mesh of a pair of gears: the margin of the rough, worn contact at each.",
    "# Chosen   the load of each place grows in 10 s, while the pinion wears; what no drawing",
    "#          gives (correlation length, Hurst exponent, wear rate) is that of [surface].",
)
"""Comments at the beginning of the scene file."""


def scene_toml(meshes: Sequence[Mesh]) -> str:
    """Write a scene with the contact at each place of one or several meshes of a pair.

    Parameters
    ----------
    meshes : sequence of Mesh
        Meshes of one pair. Places without sliding have no friction heat, and are left out.

    Returns
    -------
    str
        A scene file with a row of ``[sweep] along`` for each place.

    Raises
    ------
    InputError
        If the contact is so wide that the roughness would need too many pixels.

    Examples
    --------
    >>> import pipeline.gears
    >>> mesh = pipeline.gears.mesh(pipeline.gears.read_pair("fzg_a"), places=2)
    >>> scene_toml([mesh]).count("motion.slide_roll_ratio")  # at A, B, D and E
    4
    """
    pair, surface = meshes[0].pair, meshes[0].pair.file.surface
    places = [(number, one, place) for number, one in enumerate(meshes, 1)
              for place in one.places if place.sliding]  # fmt: skip
    hertz = max(2 * place.half_width for _, _, place in places)
    peaks = 8 * _PEAKS * pair.rms_roughness
    widest = max(
        math.sqrt(4 * place.half_width**2 + peaks * place.reduced_radius) for _, _, place in places
    )
    along, across = (length / _PIXELS_A_LENGTH for length in surface.correlation_length)
    side = min(along, hertz / _PIXELS_A_WIDTH), across
    count = 8 * math.ceil(_ROOM * widest / side[0] / 8)  # presets average up to 8 pixels
    if count > _MOST_PIXELS:
        raise InputError(
            f"surface.correlation_length is {display(4 * along, 'µm', 3)} along the sliding, on a "
            f"contact {display(widest, 'mm', 3)} wide: {count} pixels of a quarter of it are more "
            f"than {_MOST_PIXELS}; give a longer length"
        )
    highest = max(place.load for _, _, place in places)
    width = pair.gears.face_width / math.cos(pair.gears.base_helix_angle)
    names = pair.file.pinion.material, pair.file.wheel.material
    sd = pair.file.temperature.critical_sd
    rows = [_row(number if len(meshes) > 1 else 0, one, place) for number, one, place in places]
    tables: dict[str, dict[str, Any]] = {
        **{f"materials.{as_toml(name)}": pair.written["materials"][name]
           for name in dict.fromkeys(names)},
        "pin": {"shape": "cylinder", "radius": rows[0]["pin.radius"],
                "length": display(width, "mm", 7), "material": names[0]},
        "disk": {"material": names[1]},
        "window": {"pixels": [count, _ALONG_Y],
                   "pixel_size": [display(one, "um", 7) for one in side]},
        "loading": {"rate": f"{highest / _RAMP:.7g} N/s", "reference_load": f"{highest:.7g} N"},
        "wear": {"specific_wear_rate": display(surface.specific_wear_rate, "mm^3/(N m)", 7),
                 "pattern": "swept"},
        "friction": {"coefficient": round(meshes[0].friction, 6)},
        "temperature": {
            "bulk": display(meshes[0].duty.bulk, "degC", 7),
            "critical": pair.critical and display(pair.critical, "degC", 7),
            "critical_sd": sd and display(sd, "K", 7),
        },
        "disk.roughness": {
            "ra": display(math.hypot(*pair.roughness), "um", 7),
            "hurst_exponent": surface.hurst_exponent,
            "correlation_length": [display(one, "um", 7) for one in surface.correlation_length],
        },
        "oil": pair.written.get("oil") or {},
    }  # fmt: skip
    lines = [*_HEAD, "", f"title = {as_toml(f'{pair.title}: places of mesh')}"]
    lines += [f"caveat = {as_toml(UNTESTED)}"]
    for name, table in filter(itemgetter(1), tables.items()):
        entries = {k: v for k, v in table.items() if v is not None and k != "like"}
        lines += ["", f"[{name}]", *(f"{key} = {as_toml(value)}" for key, value in entries.items())]
    lines += ["", "[sweep]", "along = [", *(f"  {as_toml(row)}," for row in rows), "]"]
    return "\n".join([*lines, ""])


def _row(number: int, mesh: Mesh, place: MeshPlace) -> dict[str, str | float]:
    """Row of the scene's table ``[sweep] along`` for one place of a mesh: values by column.

    `number` is the number of the mesh's duty, from 1 on, or 0 if there is only one duty. With
    several duties, friction and bulk temperature are columns of the row.
    """
    track = 2 * math.pi * place.radius_1 * math.cos(mesh.pair.gears.base_helix_angle)
    row: dict[str, str | float] = {"position": f"{place.position:.7g} m"}
    if number:
        row |= {"duty": str(number), "friction": round(mesh.friction, 6),
                "bulk_temperature": display(mesh.duty.bulk, "degC", 7)}  # fmt: skip
    mean = (place.rolling_1 + place.rolling_2) / 2
    return row | {
        "load": f"{place.load:.7g} N",
        "velocity": f"{abs(place.sliding):.7g} m/s",
        "pin.radius": display(place.reduced_radius, "mm", 7),
        "motion.slide_roll_ratio": round(-place.sliding / mean, 7),
        "motion.track_length": display(track, "mm", 7),
    }
