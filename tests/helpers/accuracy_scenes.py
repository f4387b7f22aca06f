"""A small scene like the paper's, and another material."""

import tribo
from pipeline import Conditions
from tests.helpers.scenes import STEEL
from tests.helpers.sweeps import sweep_of_fields

ALUMINA = tribo.Material(
    elastic_modulus=310e9,
    poisson_ratio=0.25,
    hardness=20e9,
    thermal_conductivity=25.0,
    density=3900.0,
    specific_heat=780.0,
)

PAPER = sweep_of_fields(
    pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
    disk=STEEL,
    pixels=tribo.Grid((120, 60), (3.2e-6, 3.2e-6)),
    loading=tribo.Ramp(rate=150.0, reference_load=750.0),
    roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (8e-6, 8e-6), seed=0),
    wear=tribo.Wear(1.2e-15),
    name="paper",
    title="The paper's system on a small window",
    loads=(200.0, 300.0, 400.0, 500.0, 750.0),
    velocities=(0.5, 1.0, 2.0, 4.0),
    conditions=Conditions(0.1, 298.15, 418.15),
)
