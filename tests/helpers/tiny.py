"""A sweep that takes milliseconds a point, and ramps that go wrong on a worker."""

import math
import multiprocessing
import os
import signal
import sys
import time

import tribo
from pipeline import Conditions
from tests.helpers.scenes import STEEL
from tests.helpers.sweeps import sweep_of_fields

LOADS, VELOCITIES = (150.0, 250.0, 600.0), (0.5, 1.0, 1.5)


def sweep(increments=6, fidelity=None, **changes):
    """Sweep of nine points of milliseconds, with load steps every 125 N and points at 250 N."""
    return sweep_of_fields(
        **{
            "pin": tribo.Cylinder(radius=8e-3, length=3.375e-3, material=STEEL),
            "disk": STEEL,
            "pixels": tribo.Grid((32, 16), (13e-6, 15e-6)),
            "loading": tribo.Ramp(rate=150.0, reference_load=750.0),
            "roughness": tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 9e-6), seed=1),
            "wear": tribo.Wear(1.2e-15),
            "fidelity": tribo.Fidelity(
                **{"pixels_per_element": 1, "increments": increments} | (fidelity or {})
            ),
            "name": "tiny",
            "title": "A tiny sweep",
            "loads": LOADS,
            "velocities": VELOCITIES,
            "conditions": Conditions(0.1, 298.15, 418.15),
            "friction_band": (0.09, 0.103),
            "tests": (),
        }
        | changes
    )


def full(**changes):
    """The tiny sweep with fields, so that its store has all kinds of variables."""
    return sweep(**{"fields": True} | changes)


def _on_a_worker():
    """True in a worker process of Dask, whether started from here or by its command."""
    return multiprocessing.parent_process() is not None or "dask_worker" in sys.argv[0]


def _remade(kind, *values):
    return kind(*values[:-1], faulty_load=values[-1])


class FaultyRamp(tribo.Ramp):
    """A ramp that calls `fault` at one load, only in workers and not when points are planned."""

    def __init__(self, *args, faulty_load=math.nan, **keywords):
        super().__init__(*args, **keywords)
        object.__setattr__(self, "faulty_load", faulty_load)

    def __reduce__(self):
        values = self.rate, self.reference_load, self.hold, self.faulty_load
        return _remade, (type(self), *values)

    def load_steps(self, normal_load, increments, hold_increments=0):
        if normal_load == self.faulty_load and _on_a_worker():
            self.fault()
        return tribo.Ramp.load_steps(self, normal_load, increments, hold_increments)


class DeadlyRamp(FaultyRamp):
    def fault(self):
        os.kill(os.getpid(), signal.SIGKILL)


class DivergingRamp(FaultyRamp):
    def fault(self):
        raise tribo.ConvergenceError("the contact did not converge", solution=None)


class SlowRamp(FaultyRamp):
    """A ramp that takes 0.2 s at every load in workers, as a large scene does."""

    def load_steps(self, normal_load, increments, hold_increments=0):
        if _on_a_worker():
            time.sleep(0.2)
        return tribo.Ramp.load_steps(self, normal_load, increments, hold_increments)


class EndlessRamp(FaultyRamp):
    """A ramp whose points at one load take ten minutes, longer than any test waits."""

    def fault(self):
        time.sleep(600)


for kind in (FaultyRamp, DeadlyRamp, DivergingRamp, SlowRamp, EndlessRamp):
    kind.__name__ = "Ramp"  # stores keep them as a Ramp, whose digest depends on its values only
