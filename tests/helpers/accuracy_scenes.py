"""Small scenes on which accuracy is promised, each unlike the shipped one in another way."""

import tribo
from pipeline.sweep.conditions import Conditions
from tests.helpers.entries import changed
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

SCENES = {
    "finer pixels": changed(
        PAPER,
        pixels=tribo.Grid((192, 96), (2.04e-6, 2.04e-6)),
        loads=(200.0, 250.0, 300.0, 350.0, 400.0, 500.0, 600.0, 750.0),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6), seed=0),
    ),
    "another radius": changed(
        PAPER,
        pin=tribo.Cylinder(5e-3, 3.4e-3, STEEL),
        pixels=tribo.Grid((128, 60), (4.5e-6, 3.2e-6)),
    ),
    "low loads": changed(
        PAPER,
        loads=(60.0, 80.0, 100.0, 130.0, 180.0),
        loading=tribo.Ramp(60.0, 180.0),
        conditions=Conditions(0.1, 298.15, 378.15),
    ),
    "other materials": changed(PAPER, pin=tribo.Cylinder(2e-3, 3.4e-3, ALUMINA)),
    "rougher, with a lay": changed(
        PAPER, roughness=tribo.SelfAffineRoughness(0.5e-6, 0.7, (8e-6, 25e-6), seed=3)
    ),
    "local wear": changed(PAPER, wear=tribo.Wear(1.2e-15, "local")),
    "no wear": changed(PAPER, wear=None),
    "smooth": changed(PAPER, roughness=None),
}
