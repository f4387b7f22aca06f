"""Contacts at the end of points in closed form, before any simulation.

Compared with simulations, the width under smooth pins is within 3 % and the depth within 10 %;
on rough disks the width is within 12 %.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tribo import Scene, contact_modulus
from tribo.types import Array
from tribo.wear import wear_over

_ROUGH_RISE = 3.0  # root mean square heights by which peaks reach beyond the smooth contact


def expect_contacts(
    scene: Scene, loads: Sequence[float], velocities: Sequence[float], rms_height: float = 0.0
) -> dict[str, Array]:
    """Estimate contact and wear at the end of each point, in closed form.

    `rms_height` is the Rq of the disk [m]. Returns arrays by name. Of shape (n_load,) are
    ``hertz_pressure`` [Pa], ``hertz_half_width`` [m] and ``duration`` [s]. Of shape (n_load,
    n_velocity) are ``contact_width``, ``sliding_distance`` and, if the pin wears, ``wear_depth``,
    all in metres.

    Examples
    --------
    >>> import pipeline
    >>> first_try = pipeline.load_scene("workflows/first_try.toml").scene
    >>> expected = expect_contacts(first_try, [600.0], [1.5])
    >>> f"{1e6 * expected['contact_width'][0, 0]:.0f} µm wide"
    '258 µm wide'
    """
    modulus = contact_modulus(scene.pin.material, scene.disk)
    hertz = [scene.pin.hertz(load, modulus) for load in loads]
    half_widths = np.array([contact.half_width for contact in hertz])
    durations, impulses = np.transpose([_course(scene, load) for load in loads])
    slid, wear = np.outer(durations, velocities), scene.wear
    mean = math.pi / 4 if scene.pin.length is not None else 2 / 3  # over the peak pressure
    rates = np.zeros(slid.shape)
    for (load, place), end in np.ndenumerate(slid):
        if wear:
            pressure = mean * hertz[load].peak_pressure
            whole = wear_over(wear, 0.0, end, pressure, velocities[place])
            rates[load, place] = whole.specific_wear_rate
    worn = rates * np.outer(impulses, velocities)
    if scene.velocities_at(max(velocities)).pin:  # it rolls: it wears all around, and stays round
        unworn = 2 * half_widths[:, None]
        along_y = unworn / 1.5 if scene.pin.length is None else scene.pin.length
        widths, depths = unworn + 0 * worn, worn / (scene.track_length * along_y)
    else:
        widen = np.vectorize(scene.pin.worn, otypes=[float, float])
        widths, depths = widen(half_widths[:, None], worn)
    if rms_height:
        widths = np.sqrt(widths**2 + 8 * scene.pin.radius * _ROUGH_RISE * rms_height)
    made = {
        "hertz_pressure": np.array([contact.peak_pressure for contact in hertz]),
        "hertz_half_width": half_widths,
        "contact_width": widths,
        "duration": durations,
        "sliding_distance": slid,
    }
    return made | ({"wear_depth": depths} if wear else {})


def _course(scene: Scene, load: float) -> tuple[float, float]:
    """Duration of the loading to a load and of its hold [s], and the load's time integral [N s]."""
    stations = list(scene.all_stations(load))
    times = np.array([0.0, *(station.time for station in stations)])
    loads = np.array([0.0, *(station.normal_load for station in stations)])
    return float(times[-1]), float(np.trapezoid(loads, times))
