"""Inputs of all sweeps that tests weigh together, and the likelihood of the tests."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.discrepancy import SLOPES, Slopes
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.evidence import (
    SIGNS,
    Distances,
    Test,
    distances_of,
    log_likelihoods,
    require_possible,
)
from pipeline.uncertain.rig import Places, with_rigs
from tribo import InputError
from tribo.types import Array

OF_LUBRICANT = ("temperature.", "wear.", "friction.", "oil.")
"""Beginnings of the paths of inputs that each sweep has of its own; others are shared."""
FACTORS = np.exp(np.log(2.0) * np.linspace(-2.0, 2.5, 10))
"""Factors on the scatter that is said."""
_LOG_PRIOR = -0.5 * (np.log(FACTORS) / math.log(2.0)) ** 2  # of the factors
_FAR = 2.0  # largest standard deviations of a test from the best draw, root mean square


class Judgement(NamedTuple):
    """Tests beside draws: distances, the results of `log_likelihoods`, and the sum of all of them.

    ``joint``, shape (n, n_scatter), has the prior of the scatters in.
    """

    distances: Distances
    z: Array
    likelihoods: Array
    joint: Array


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """Inputs of all sweeps, and their tests.

    ``unknown`` are those of the sweeps, of which there are ``known``, then those of the rigs, then
    the slopes of a discrepancy if there is one. ``columns`` are the inputs of each sweep among all.
    """

    ensembles: tuple[Ensemble, ...]
    unknown: tuple[Unknown, ...]
    known: int
    columns: tuple[Any, ...]
    rigs: tuple[Places | None, ...]
    has_discrepancy: bool
    scatters: Array

    @classmethod
    def of(cls, ensembles: tuple[Ensemble, ...], scatter: float, discrepancy: bool) -> Joint:
        """Join the inputs of sweeps; raises at a test that a sweep says nothing about."""
        unknown, columns = _joined(ensembles)
        for one in ensembles:
            require_possible(one)
        known, (unknown, rigs) = len(unknown), with_rigs(ensembles, unknown, columns)
        unknown += SLOPES if discrepancy else ()
        return cls(ensembles, unknown, known, columns, rigs, discrepancy, scatter * FACTORS)

    @property
    def tests(self) -> list[Test]:
        """Tests of all sweeps, in their order."""
        return [test for one in self.ensembles for test in one.tests]

    @property
    def sweeps(self) -> list[int]:
        """Number of the sweep of each test."""
        return [number for number, one in enumerate(self.ensembles) for _ in one.tests]

    def judged(self, inputs: Array) -> Judgement:
        """Tests beside draws of all inputs, shape (n, n_unknown)."""
        slopes = Slopes.of(inputs) if self.has_discrepancy else None
        parts = [
            distances_of(one, one.tests, inputs[:, part], places and places.rig(inputs), slopes)
            for one, part, places in zip(self.ensembles, self.columns, self.rigs, strict=True)
        ]
        distances = Distances(*(np.concatenate(part) for part in zip(*parts, strict=True)))
        z, likelihoods = log_likelihoods(self.tests, distances, self.scatters)
        return Judgement(distances, z, likelihoods, likelihoods.sum(axis=0) + _LOG_PRIOR)

    def require_near(self, distances: Distances) -> None:
        """Raise an `InputError` where even the best draws are far from the tests."""
        scatter = float(self.scatters[-1])
        z = distances.values / np.sqrt(distances.variance + scatter**2)
        for number, test in enumerate(self.tests):
            if "outcome" in test:
                z[number] = np.minimum(SIGNS[test["outcome"]] * z[number], 0.0)
        apart = float(np.sqrt(np.mean(z**2, axis=0).min()))
        if apart > _FAR:
            raise InputError(
                f"hardly any draw agrees with the tests, the best within {apart * scatter:.0%} of "
                "their velocities; widen [unknown], or look at the tests"
            )


def _joined(ensembles: Sequence[Ensemble]) -> tuple[tuple[Unknown, ...], tuple[Any, ...]]:
    """Unknown inputs of all sweeps, and those of each among them."""
    inputs: dict[str, Unknown] = {}
    columns = []
    for number, ensemble in enumerate(ensembles, 1):
        name = _names(number if len(ensembles) > 1 else None)
        for quantity in ensemble.unknown:
            named = replace(
                quantity,
                path=name(quantity.path),
                correlated=tuple((name(path), value) for path, value in quantity.correlated),
            )
            same = inputs.setdefault(named.path, named)
            if (same.kind, same.parameters) != (named.kind, named.parameters):
                raise InputError(
                    f"{quantity.path} is shared by the sweeps, which differ in its distribution; "
                    "give the same one in [unknown] of each, and run them again"
                )
        paths = [name(quantity.path) for quantity in ensemble.unknown]
        columns.append(np.array([[*inputs].index(path) for path in paths], int))
    return tuple(inputs.values()), tuple(columns)


def _names(number: int | None) -> Callable[[str], str]:
    """Names of inputs of one sweep among several, by their paths."""

    def name(path: str) -> str:
        return f"{number}: {path}" if number and path.startswith(OF_LUBRICANT) else path

    return name
