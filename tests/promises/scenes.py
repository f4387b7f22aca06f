"""Random scenes of the family on which accuracy is promised."""

import math
from dataclasses import replace

import numpy as np

import tribo
from pipeline import Conditions
from tests.helpers.accuracy_scenes import ALUMINA
from tests.helpers.entries import changed
from tests.helpers.scenes import STEEL
from tests.helpers.sweeps import sweep_of_fields
from tribo.simulation import state_rises

BRONZE = tribo.Material(110e9, 0.34, 60.0, 8800.0, 380.0, 1.5e9)
SOFT_STEEL = tribo.Material(210e9, 0.3, 50.0, 7850.0, 460.0, 1.8e9)
PAIRS = ((STEEL, STEEL), (ALUMINA, STEEL), (SOFT_STEEL, STEEL), (BRONZE, STEEL))
# Fidelity to find the scenes; no preset, so that the scenes do not change with the presets.
ROUGHLY = tribo.Fidelity(
    pixels_per_element=4, history_coarsening=4, increments=10, contact_tolerance=0.1
)
SHARES = (0.3, 0.5, 0.7, 1.0)  # loads over the reference load


def random_sweep(seed):
    """Random sweep of a cylinder of 1 to 20 mm on a ground disk; the same for the same seed.

    Ra is 0.02 to 1 µm, wear none, swept or local at 1e-9 to 1e-4 mm³/(N m). The window holds the
    contact, and the critical temperature is such that the boundary lies among the velocities.
    """
    rng = np.random.default_rng(seed)

    def log(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    pin, disk = PAIRS[rng.integers(len(PAIRS))]
    pattern = (None, "swept", "local")[rng.integers(3)]
    radius, length = log(1e-3, 20e-3), log(2e-3, 10e-3)
    modulus = tribo.contact_modulus(pin, disk)
    peak = rng.uniform(0.15, 0.4) * min(pin.hardness, 4e9)
    half_width = 2 * radius * peak / modulus  # Hertz, a line
    load = math.pi / 2 * half_width * peak * length
    shape = int(rng.choice([96, 128, 160])), int(rng.choice([48, 64, 96]))
    pixel = 4.0 * half_width / shape[0]
    velocity, duration = log(0.1, 8.0), rng.uniform(2.0, 8.0)
    wear = tribo.Wear(log(1e-18, 1e-13), pattern) if pattern else None
    spread = np.geomspace(1 / 4, 6, int(rng.choice([6, 24])))
    sweep = sweep_of_fields(
        pin=tribo.Cylinder(radius, length, pin),
        disk=disk,
        pixels=tribo.Grid(shape, (pixel, pixel)),
        loading=tribo.Ramp(load / duration, load),
        roughness=tribo.SelfAffineRoughness(
            log(0.02e-6, 1e-6), rng.uniform(0.5, 0.9), (1.0, 1.0), seed
        ),
        wear=wear,
        name=f"scene {seed}",
        title=f"Random scene {seed}",
        loads=tuple(load * share for share in SHARES),
        velocities=tuple(velocity * spread),
        conditions=Conditions(0.1, 298.15, 400.0),
        fidelity=ROUGHLY,
    )
    lengths = [rng.uniform(2, 8), rng.uniform(2, 8)]  # correlation lengths in pixels
    return with_boundary(window_guess(sweep, lengths, velocity), sweep.loads[2], velocity)


def window_guess(sweep, lengths, velocity):
    """Copy of a sweep with a window so wide that the contact does not touch its edges.

    `lengths` are the correlation lengths in pixels.
    """
    for _ in range(12):
        sizes = sweep.scene.pixels.spacing
        if sweep.scene.roughness is not None:
            along = tuple(n * size for n, size in zip(lengths, sizes, strict=True))
            sweep = changed(
                sweep, roughness=replace(sweep.scene.roughness, correlation_length=along)
            )
        ends = (sweep.loads[-1], velocity), (sweep.loads[0], 4 * velocity)
        warnings = [
            warning
            for end in ends
            for warning in tribo.warnings(sweep.scene, state_at(sweep.scene, *end))
        ]
        if tribo.WarningKind.CONTACT_AT_EDGE not in (warning.kind for warning in warnings):
            break
        wider = tuple(1.4 * size for size in sizes)
        sweep = changed(sweep, pixels=replace(sweep.scene.pixels, spacing=wider))
    return sweep


def with_boundary(sweep, load, velocity):
    """Copy of a sweep with a critical temperature at which wear turns severe at this point."""
    scene = sweep.cases[0].scene
    state = state_at(scene, load, velocity)
    rise = float(sweep.conditions.governing_rise(state_rises(scene, state, None)))
    critical = sweep.conditions.bulk_temperature + sweep.conditions.friction * rise
    return changed(sweep, conditions=replace(sweep.conditions, critical_temperature=critical))


def state_at(scene, load, velocity):
    """The hottest state of a point at its full load."""
    hot = [
        state
        for state in tribo.simulate(scene, load, velocity)
        if state.heat is not None and state.normal_load >= load
    ]
    return max(hot, key=lambda state: state.heat.max_rise) if len(hot) > 1 else hot[0]
