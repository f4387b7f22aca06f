"""A plane whose boundary is known in closed form, with realizations at random, to be searched.

The boundary, exponents and deviations of realizations are those of the scene irg_transition at 200,
400, 600 and 750 N. Realizations at two loads are correlated by `correlation` to the power of the
ratio of ln(load ratio) to ln(750/200).
"""

from typing import NamedTuple

import numpy as np

from pipeline.answers.error import SURFACE, rise_errors, velocity_errors
from pipeline.run.search import Goal
from pipeline.sweep.case import allowable_rise
from tests.helpers.search_in_memory import Told
from tribo import Conditions

LOADS = {
    4: np.array([200.0, 400, 600, 750]),
    5: np.array([200.0, 300, 450, 600, 750]),
    12: np.arange(200.0, 751, 50),
    15: np.geomspace(200, 750, 15),
    30: np.geomspace(200, 750, 30),
}
"""Loads of sweeps [N], by their number."""
_VELOCITIES = np.arange(0.5, 5.01, 0.25)
_X = np.log([200.0, 400, 600, 750])
_BOUNDARY = np.polyfit(_X, np.log([3.606, 2.244, 1.555, 1.232]), 2)
_EXPONENTS = 0.64, 0.57, 0.54, 0.53  # d ln(rise)/d ln(velocity)
_DEVIATIONS = 0.022, 0.0125, 0.0088, 0.0068  # of ln(rise), from realization to realization
_ROUGHNESS = 0.0015  # of ln(rise), from point to point
_CONDITIONS = Conditions(0.1, 298.15, 418.15)
_MOST = 256  # realizations
_DRIFT = np.linspace(np.log(0.2), np.log(12.0), 200)  # ln(velocity) at which drifts are known


class PlaneModel:
    """Rises of realizations over the plane.

    Parameters
    ----------
    loads : ndarray
        Loads [N].
    seed : int
        Seed of the realizations.
    correlation : float, optional
        Of realizations at 200 and 750 N.
    scale : float, optional
        Factor of all deviations of realizations.
    steepness : float, optional
        Factor of the slope of the boundary, ln(velocity) over ln(load).
    drift : float, optional
        Distance in ln(velocity) after which two rises of a realization are independent but for
        their common level; 0 if this level is all that realizations differ by.
    freedom : float, optional
        Degrees of freedom of the deviation that each point states.
    """

    def __init__(
        self, loads, seed, correlation=0.65, scale=1.0, steepness=1.0, drift=0.0, freedom=7.0
    ):
        self.loads, self._generator = loads, np.random.default_rng([0, seed, len(loads)])
        self._freedom = freedom
        self._steepness, x = steepness, np.log(loads)
        self.exponents = np.interp(x, _X, _EXPONENTS)
        self.deviations = scale * np.exp(np.interp(x, _X, np.log(_DEVIATIONS)))
        distance = np.abs(x[:, None] - x) / np.log(3.75)
        matrix = correlation**distance if correlation else np.eye(len(x))
        self._factor = np.linalg.cholesky(matrix + 1e-12 * np.eye(len(x)))
        shape = _MOST, len(x)
        self._levels = self._correlated(shape)
        self._roughness = _ROUGHNESS * self._generator.standard_normal((*shape, 500))
        self._drifts = None
        if drift:
            steps = np.stack([self._correlated(shape) for _ in _DRIFT], axis=-1)
            spacing = _DRIFT[1] - _DRIFT[0]
            self._drifts = np.cumsum(steps * np.sqrt(2 * spacing / drift), axis=-1)

    def _correlated(self, shape):
        return self._generator.standard_normal(shape) @ self._factor.T * self.deviations

    def log_critical(self, loads):
        """ln(critical velocity) of the specimen [m/s]."""
        middle = np.polyval(_BOUNDARY, _X).mean()
        return middle + self._steepness * (np.polyval(_BOUNDARY, np.log(loads)) - middle)

    def rise(self, place, velocity, index):
        """Rise of a realization at a point [K]; `index` numbers the point's velocity."""
        realization, load = place
        distance = np.log(velocity) - self.log_critical(self.loads[load])
        y = self.exponents[load] * distance + self._levels[realization, load]
        y += self._roughness[realization, load, index]
        if self._drifts is not None:
            drift = self._drifts[realization, load]
            positions = np.log(velocity), self.log_critical(self.loads[load])
            y += np.subtract(*np.interp(positions, _DRIFT, drift))
        return allowable_rise(_CONDITIONS) * np.exp(y)

    def search(self, accuracy, promised):
        """A search for an accuracy, run to its end; `promised` is the error of the preset."""
        goal = Goal(accuracy, _MOST)
        search = Told(self.loads, _VELOCITIES, _CONDITIONS, promised, goal, self._freedom)
        while batch := search.ask():
            rises = [
                self.rise(place[:2], search.velocities[place.velocity], place.velocity)
                for place in batch
            ]
            stated = self.deviations[[place.load for place in batch]] * np.sqrt(
                self._generator.chisquare(self._freedom, len(batch)) / self._freedom
            )
            search.tell(batch, np.array(rises), stated)
        return search


class Verdict(NamedTuple):
    """What a search of a model came to."""

    points: int
    stated: float  # largest error at a load
    is_held_at: np.ndarray  # True where the stated error holds, without that of the preset
    is_held_between: np.ndarray  # the same, halfway between two loads

    @classmethod
    def of(cls, model, search):
        """Judge a search by the boundary of its model."""
        loads = model.loads
        between = np.sqrt(loads[1:] * loads[:-1])
        field, specimen = search.specimen.field, search.specimen
        limits = np.full(len(between), search.limit)
        critical = field.along_velocity(between, limits).critical
        parts = rise_errors(specimen, search.promised, field.at(between, critical))
        parts = velocity_errors(field, parts, between, critical)
        return cls(
            points=int(search.asked.sum()),
            stated=float(np.sqrt(np.square(search.errors).sum(axis=0)).max()),
            is_held_at=_is_held(model, loads, search.critical, search.errors),
            is_held_between=_is_held(model, between, critical, parts),
        )


def _is_held(model, loads, critical, parts):
    """True where the error of a critical velocity is at most that stated, without the preset's."""
    stated = np.sqrt(np.square(parts[[0, 2, SURFACE]]).sum(axis=0))
    return np.abs(np.log(critical) - model.log_critical(loads)) <= stated
