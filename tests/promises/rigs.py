"""Hidden truths as rigs: tests of them are direct simulations, and are logged with errors."""

import functools
import math
import os
import tempfile
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
from scipy.optimize import brentq

import pipeline
from pipeline import run_point
from pipeline.sweep.severity import rise_limit, worst_rises
from pipeline.sweep.variants import Variants
from pipeline.uncertain import weigh
from pipeline.uncertain.answers import log_crossings
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import CRITICAL, FRICTION
from pipeline.uncertain.unknown import score_values
from tests.helpers.entries import changed
from tests.promises.risk import WORKFLOWS, entries_of

SCATTER, FRICTION_SCATTER = 0.05, 0.02
_SEED = 2718  # seed of the hidden truths
_FIRST = 2**15  # draws of the prior; with four times the usual number few truths need more
_KEPT = 8  # most cached arrays of rises, some 100 MB each
_CLOSE = 1e-3  # tolerance of a boundary in ln(velocity)
_STEP = 0.03  # first step of ln(velocity), doubled until it passes the boundary

# The critical temperature is little known in all cases. "known": measured steel and wear rate,
# tests at one bulk temperature; "unknown": neither, tests at three; "ball": a ball on a disk.
CASES = {
    "known": {
        f"unknown.{CRITICAL}": {"mean": "145 degC", "sd": "20 K"},
        "unknown.wear.specific_wear_rate": {"median": "1.2e-6 mm^3/(N m)", "factor": 1.1},
    },
    "unknown": {
        f"unknown.{CRITICAL}": {"mean": "145 degC", "sd": "20 K"},
        "unknown.materials.steel.thermal_conductivity": {
            "from": "21 W/(m K)",
            "to": "46 W/(m K)",
        },
        "sweep.velocities": ["0.2 m/s", "6 m/s"],
    },
    "ball": {
        "pin.shape": "ball",
        "pin.radius": "5 mm",
        "window.pixels": [240, 240],
        "window.pixel_size": ["2.5 um", "2.5 um"],
        "loading.rate": "150 N/s",
        "loading.reference_load": "300 N",
        "sweep.loads": ["50 N", "100 N", "200 N", "300 N"],
        "sweep.velocities": ["0.1 m/s", "4 m/s"],
        f"unknown.{CRITICAL}": {"mean": "145 degC", "sd": "20 K"},
        "unknown.wear.specific_wear_rate": {"median": "1.2e-6 mm^3/(N m)", "factor": 1.3},
        f"unknown.{FRICTION}": {"mean": 0.1, "sd": 0.01},
        "without": ["pin.length", "friction.band"],
    },
}
BULKS = {"known": (298.15,), "unknown": (298.15, 338.15, 378.15), "ball": (298.15, 338.15)}  # [K]


def add_rig_options(parser):
    """Add the command-line options that choose the rigs to try."""
    parser.add_argument("--case", choices=CASES, default="known")
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--store", type=Path, help="of the scene's samples; computed if not given")
    parser.add_argument("--preset", default="draft")


def rigs_of(options):
    """Ensemble of the scene in the options, and a function from a number to a `Rig`."""
    overrides = {"fidelity.preset": options.preset} | CASES[options.case]
    ensemble = ensemble_of(options.scene, overrides, options.store)
    return ensemble, functools.partial(Rig, ensemble, options.scene, overrides)


def ensemble_of(scene, overrides, store=None):
    """Ensemble of a scene's samples, read from a store or simulated now."""
    if store is not None:
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
        return replace(ensemble, tests=())
    sweep = pipeline.load_scene(scene, overrides=overrides)
    sweep = changed(sweep, fields=False, measured=(), tested=())
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "samples.zarr"
        pipeline.run_sweep(sweep, store, workers=os.cpu_count())
        return pipeline.Ensemble.of(pipeline.open_sweep(store))


def weighed(ensemble, tests, scatter=SCATTER):
    """Posterior given tests; the emulator of the samples is fitted only once."""
    tested = replace(ensemble, tests=tuple(tests))
    vars(tested)["_rise"] = ensemble._rise
    with mock.patch.object(Ensemble, "excess", _kept), mock.patch.object(weigh, "_FIRST", _FIRST):
        return pipeline.posterior(tested, scatter)


def log_transitions(ensemble, inputs, load, bulk):
    """Logarithm of the emulated critical velocity of each draw at a load and bulk temperature."""
    nodes = np.geomspace(*ensemble.velocities, 9)
    at_bulk = replace(ensemble, conditions=replace(ensemble.conditions, bulk_temperature=bulk))
    vars(at_bulk)["_rise"] = ensemble._rise
    return log_crossings(nodes, at_bulk.excess(inputs, load, nodes).values)[0]


def boundary_near(excess, place, ends):
    """Root of `excess`, which may jump, near `place` and within `ends`; None if there is none."""
    excess = functools.cache(excess)
    step = _STEP if excess(place) < 0 else -_STEP
    near = far = place
    while excess(far) * excess(place) > 0:
        near, far = far, min(max(far + step, ends[0]), ends[1])
        if far == near:
            return None
        step *= 2
    return float(brentq(excess, near, far, xtol=_CLOSE))


_excess, _of_prior = Ensemble.excess, {}


def _kept(ensemble, draws, load, velocity):
    """`Ensemble.excess` with a cache for draws of the prior, which all truths share."""
    if len(draws) < weigh._FIRST:
        return _excess(ensemble, draws, load, velocity)
    key = id(ensemble._rise), draws.tobytes(), tuple(load), tuple(velocity)
    if key not in _of_prior:
        while len(_of_prior) >= _KEPT:
            del _of_prior[next(iter(_of_prior))]
        _of_prior[key] = _excess(ensemble, draws, load, velocity)
    return _of_prior[key]


class Rig:
    """A rig with hidden true inputs, whose tests are direct simulations."""

    def __init__(self, ensemble, scene, overrides, number):
        self.ensemble, self.seed = ensemble, number
        chance = np.random.default_rng((_SEED, number))
        scores = chance.standard_normal((1, len(ensemble.unknown)))
        self.truth = score_values(ensemble.unknown, scores)[0]
        entries = entries_of(ensemble.unknown, self.truth)
        without = [*overrides.get("without", ()), "unknown", "sweep.samples"]
        alone = overrides | {"without": without} | entries
        self._scene = changed(pipeline.load_scene(scene, overrides=alone), variants=Variants())
        self._friction, self._chance = entries[FRICTION], chance
        self.simulated = functools.cache(self._simulated)

    def tried(self, load, velocity, bulk, scatter=SCATTER):
        """A test at a load, velocity and bulk temperature, as an entry of a log."""
        is_severe = self._excess(load, bulk, math.log(velocity) + scatter * self._noise()) > 0
        outcome = "severe" if is_severe else "mild"
        return self._logged(load, velocity, bulk) | {"outcome": outcome}

    def searched(self, load, bulk, scatter=SCATTER):
        """A measured transition at a load, as an entry of a log; an outcome if out of range."""
        velocity = math.exp(self.transition(load, bulk) + scatter * self._noise())
        low, high = self.ensemble.velocities
        if velocity < low:
            return self._logged(load, low, bulk) | {"outcome": "severe"}
        if velocity > high:
            return self._logged(load, high, bulk) | {"outcome": "mild"}
        return self._logged(load, velocity, bulk)

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def transition(self, load, bulk):
        """Logarithm of the true critical velocity; ± infinite if it is outside the sweep."""
        if bulk >= self._scene.conditions.critical_temperature:
            return -math.inf
        low, high = np.log(self.ensemble.velocities).tolist()
        guess = log_transitions(self.ensemble, self.truth[None], load, bulk)[0]
        place = float(np.clip(guess, low, high))
        excess = functools.partial(self._excess, load, bulk)
        found = boundary_near(excess, place, (low, high))
        return math.copysign(math.inf, -excess(place)) if found is None else found

    def _excess(self, load, bulk, log_velocity):
        if bulk >= self._scene.conditions.critical_temperature:
            return math.inf
        conditions = replace(self._scene.conditions, bulk_temperature=bulk)
        return math.log(self.simulated(load, log_velocity) / rise_limit(conditions))

    def _simulated(self, load, log_velocity):
        """Deciding rise [K] at friction 1, simulated from zero load on."""
        columns = run_point(self._scene, load, math.exp(log_velocity)).columns
        return float(worst_rises(columns, load, self._scene.conditions))

    def _noise(self):
        return float(self._chance.standard_normal())

    def _logged(self, load, velocity, bulk):
        friction = self._friction * math.exp(FRICTION_SCATTER * self._noise())
        place = {"normal_load": load, "velocity": velocity, "friction": friction}
        if bulk != self.ensemble.conditions.bulk_temperature:
            place["bulk_temperature"] = bulk
        return place | {"friction_scatter": FRICTION_SCATTER * friction}
