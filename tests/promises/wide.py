"""Random scenes of a wider family: other pins, motions, records of the load and surfaces."""

import math

import numpy as np

import tribo
from pipeline import Conditions
from pipeline.sweep.case_table import surfaces
from tests.helpers.entries import changed
from tests.helpers.sweeps import sweep_of_fields
from tests.promises.scenes import PAIRS, ROUGHLY, window_guess, with_boundary

SHARES = (0.4, 0.7, 1.0)  # loads over the reference load
_MIDDLE = 1  # number of the load whose boundary lies in the middle of the velocities


def random_wide_sweep(seed):
    """Random sweep in which every part of the scene varies; the same for the same seed.

    The pin is a cylinder, a ball or crowned, at rest or rolling. Its load is a ramp, with a hold
    or without, or a record with a dip or a late jump. The disk is smooth, rough alike in all
    directions, or ground; one scene in five is computed on two surfaces.
    """
    draw = Draw(seed)
    pin_material, disk = draw.one_of(PAIRS)
    pin = draw.pin(pin_material)
    pressure = draw.between(0.15, 0.4) * min(pin_material.hardness, disk.hardness, 4e9)
    load, half_widths = hertz(pin, disk, pressure)
    pixels = draw.pixels(pin, half_widths)
    velocity = draw.log_between(0.1, 8.0)
    sweep = sweep_of_fields(
        pin=pin,
        disk=disk,
        pixels=pixels,
        loading=draw.loading(load),
        roughness=draw.roughness(seed),
        wear=draw.wear(),
        motion=draw.motion(),
        name=f"wide scene {seed}",
        title=f"Random scene {seed} of the wider family",
        loads=tuple(load * share for share in SHARES),
        velocities=tuple(velocity * np.geomspace(1 / 4, 6, draw.one_of([6, 24]))),
        conditions=Conditions(0.1, 298.15, 400.0),
        fidelity=ROUGHLY,
    )
    sweep = window_guess(sweep, draw.lengths(), velocity)
    if sweep.scene.roughness is not None and draw.chance(1 / 5):
        sweep = changed(sweep, case_table=surfaces((seed, seed + 1000)))
    return with_boundary(sweep, sweep.loads[_MIDDLE], velocity)


class Draw:
    """Random parts of a scene."""

    def __init__(self, seed):
        self.rng = np.random.default_rng([seed, 27])

    def between(self, low, high):
        return float(self.rng.uniform(low, high))

    def log_between(self, low, high):
        return math.exp(self.between(math.log(low), math.log(high)))

    def one_of(self, values):
        return values[self.rng.integers(len(values))]

    def chance(self, share):
        return self.rng.uniform() < share

    def pin(self, material):
        radius = self.log_between(1e-3, 20e-3)
        crown = radius * self.log_between(0.5, 4.0)
        return self.one_of(
            [
                tribo.Cylinder(radius, self.log_between(2e-3, 10e-3), material),
                tribo.Ball(radius, material),
                tribo.Crowned(radius, crown, material),
            ]
        )

    def pixels(self, pin, half_widths):
        x, y = half_widths
        if isinstance(pin, tribo.Cylinder):
            shape = self.one_of([96, 128]), self.one_of([48, 64])
            return tribo.Grid(shape, (4 * x / shape[0],) * 2)
        shape = (self.one_of([72, 96]),) * 2
        return tribo.Grid(shape, (3 * x / shape[0], 3 * y / shape[0]), (False, False))

    def loading(self, load):
        duration = self.between(2.0, 8.0)
        kind = self.one_of(["ramp", "hold", "dip", "jump"])
        if kind in ("ramp", "hold"):
            hold = duration * self.between(0.3, 2.0) if kind == "hold" else 0.0
            return tribo.Ramp(load / duration, load, hold)
        low, begin = self.between(0.1, 0.5), self.between(0.3, 0.6)
        if kind == "dip":
            times, shares = [0, begin, 0.5 + begin / 2, 1], [0, begin + 0.2, low, 1]
            return tribo.MeasuredLoad(duration * np.array(times), load * np.array(shares))
        wait, jump = self.log_between(2.0, 30.0), self.log_between(0.01, 1.0)
        return tribo.MeasuredLoad(
            np.array([0.0, 1.0, 1.0 + wait, 1.0 + wait + jump]), load * np.array([0, low, low, 1])
        )

    def roughness(self, seed):
        if self.chance(1 / 10):
            return None
        ra = self.log_between(0.02e-6, 0.3e-6)  # most balls touch on 400 elements
        return tribo.SelfAffineRoughness(ra, self.between(0.5, 0.9), (1.0, 1.0), seed)

    def lengths(self):
        """Correlation lengths along x and y, in pixels: a third of the disks are ground."""
        length = self.between(2, 5)
        if self.chance(1 / 3):
            return self.one_of([(length, 6 * length), (6 * length, length)])
        return length, self.between(2, 8)

    def wear(self):
        rate, pattern = self.log_between(1e-18, 1e-13), self.one_of([None, "swept", "local"])
        return tribo.Wear(rate, pattern) if pattern else None

    def motion(self):
        if self.chance(2 / 3):
            return None
        return tribo.Motion(slide_roll_ratio=self.between(0.2, 1.9) * self.one_of([1, -1]))


def hertz(pin, disk, pressure):
    """Load [N] and half-widths [m] of a contact with this maximum pressure; rough for a crown."""
    modulus = tribo.contact_modulus(pin.material, disk)
    if isinstance(pin, tribo.Cylinder):
        half_width = 2 * pin.radius * pressure / modulus
        return math.pi / 2 * half_width * pressure * pin.length, (half_width, half_width)
    crown = getattr(pin, "crown_radius", pin.radius)
    half_width = math.pi * pressure * math.sqrt(pin.radius * crown) / (2 * modulus)
    oblong = (crown / pin.radius) ** (1 / 3)
    load = 2 / 3 * math.pi * pressure * half_width**2
    return load, (half_width / oblong, half_width * oblong)
