"""Numbers that the paper of Bosman & de Rooij prints, as far as they are compared with here.

Every number is the paper's own, from its tables, its text or its figures.
"""

from __future__ import annotations

import numpy as np

CYLINDER_PEAK_PRESSURE = 1.01e9
"""Peak pressure in the example of Fig. 4 [Pa]."""
CYLINDER_HALF_WIDTH = 0.14e-3
"""Half-width of the contact in the example of Fig. 4 [m]."""
DISK_DIAMETER = 150e-3
"""Diameter of the disk [m]."""
LOADING_RATE = 150.0
"""Rate at which the load grows [N/s]."""
ROOM_CELSIUS = 25.0
"""Bulk temperature of Table 4 [°C]."""
RIG_HEATING = 15.0
"""Highest friction heating of the critical-temperature rig [K]."""
SPECIFIC_WEAR_RATE = 1.2e-15
"""Specific wear rate from the measured contact widths [m²/N]."""


TABLE_4 = np.rec.array(
    [
        (750.0, 1.25, 0.103, 348e-6, 186e-6, 0.109, 157.0),
        (600.0, 1.5, 0.100, 364e-6, 171e-6, 0.087, 153.0),
        (400.0, 2.25, 0.091, 354e-6, 153e-6, 0.121, 162.0),
        (200.0, 3.75, 0.094, 384e-6, 129e-6, 0.117, 160.0),
    ],
    formats=7 * ["f8"],
    names="normal_load,velocity,friction,measured_width,unworn_width,failed_share,max_celsius",
)
"""Transitions of Table 4, in SI but for the temperature, which is in °C."""

TABLE_6 = np.rec.array(
    [
        (25.0, 700.0, 3.25, 0.1, 332e-6, 210.0),
        (25.0, 550.0, 5.75, 0.091, 390e-6, 230.0),
        (100.0, 700.0, 1.25, 0.14, 321e-6, 208.0),
        (100.0, 400.0, 1.88, 0.14, 333e-6, 200.0),
    ],
    formats=6 * ["f8"],
    names="bulk_celsius,normal_load,velocity,friction,measured_width,max_celsius",
)
"""Transitions of Table 6, in SI but for the temperatures, which are in °C."""
