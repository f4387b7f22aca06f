"""Inputs that are not known exactly, and samples of them by a scrambled Sobol' sequence.

A longer sequence begins with the shorter one. The values of an input do not depend on inputs after
it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
import scipy  # its special functions take 0.2 s to load

from pipeline.quantities import ZERO, display
from tribo import InputError
from tribo.types import Array

Form = Literal["normal", "log-normal", "uniform", "list"]

MOST_INPUTS = 32  # most inputs that may be unknown
OF_90 = 1.645
"""Half width of a 90 % interval of the normal distribution, in standard deviations."""
_LEAST = 1e-6  # least share of an input's variance that its correlations leave unexplained
_OUTERMOST = 7.0  # largest normal score drawn
_OFF_FACES = 2.0**-40  # distance from 0 and 1, where a normal score would be infinite


@dataclass(frozen=True, slots=True)
class Unknown:
    """An input that is not known exactly, named by the path of its entry.

    Its parameters [SI] depend on its kind: mean and standard deviation (normal); median and factor,
    within which two thirds lie (log-normal); lowest and highest value (uniform); or equally likely
    values (list). Correlations with earlier inputs are between normal scores. `written` is for
    display only.
    """

    path: str
    kind: Form
    parameters: tuple[float, ...]
    unit: str = "1"
    written: str = field(default="", compare=False)  # unit in the scene file, if known
    correlated: tuple[tuple[str, float], ...] = ()
    varies: bool = False  # True if it differs from part to part

    def __post_init__(self) -> None:
        terms = self.parameters
        if self.kind not in get_args(Form) or not all(map(math.isfinite, terms)):
            raise InputError(f"{self.kind} with {terms} is not a distribution; give finite numbers")
        first, last = self.text(terms[0]), self.text(terms[-1])
        fault = None
        match self.kind, terms:
            case "normal", (_, spread) if spread <= 0:
                fault = f"sd is {spread:g}; give a value above 0"
            case "log-normal", (median, _) if median <= 0:
                fault = f"median is {first}; give a value above 0"
            case "log-normal", (_, factor) if factor <= 1:
                fault = f"factor is {factor:g}; give a value above 1, such as 1.5"
            case "uniform", (low, high) if low >= high:
                fault = f"from {first} to {last} does not rise; give the lower value first"
            case "list", _ if len(set(terms)) < max(2, len(terms)):
                fault = "give at least two different values"
        if fault:
            raise InputError(fault)

    @classmethod
    def of(cls, data: Any) -> Unknown:
        """Rebuild an input from the plain data of `as_dict`."""
        pairs = tuple((path, number) for path, number in data["correlated"])
        return cls(**data | {"parameters": tuple(data["parameters"]), "correlated": pairs})

    def quantile(self, share: Array) -> Array:
        """Quantiles of the distribution [SI] at `share`, each above 0 and below 1."""
        first, *rest = self.parameters
        if self.kind == "normal":
            return np.asarray(first + rest[0] * scipy.special.ndtri(share))
        if self.kind == "log-normal":
            return np.asarray(first * rest[0] ** scipy.special.ndtri(share))
        if self.kind == "uniform":
            return np.asarray(first + (rest[0] - first) * share)
        values = np.array(self.parameters)
        return np.asarray(values[np.minimum((share * len(values)).astype(int), len(values) - 1)])

    @property
    def is_relative(self) -> bool:
        """True if ratios of values matter rather than differences, as for log-normal inputs."""
        return self.kind == "log-normal"

    @property
    def shown(self) -> str:
        """Unit in which values are shown; empty for a plain number."""
        return self.written or ("" if self.unit == "1" else self.unit)

    @property
    def spread(self) -> str:
        """Unit in which a spread of values is shown: K for a temperature, else as `shown`."""
        return "K" if self.shown in ZERO else self.shown

    def text(self, value: float, digits: int = 6) -> str:
        """Text for a `value` [SI], such as "25 °C", with this many significant `digits`.

        The property `shown` is the unit of the text.
        """
        return display(value, self.shown, digits).rstrip()

    def as_dict(self) -> dict[str, Any]:
        """The fields as plain data, without empty fields."""
        rare = ("written", "correlated", "varies")
        return {k: v for k, v in asdict(self).items() if v or k not in rare}

    def __str__(self) -> str:
        values = [self.text(value) for value in self.parameters]
        first, second = values[0], self.parameters[1]
        words = {
            "normal": f"normal, mean {first}, sd {display(second, self.spread).rstrip()}",
            "log-normal": f"log-normal, median {first}, factor {second:.6g}",
            "uniform": f"uniform from {first} to {values[1]}",
            "list": f"one of {', '.join(values)}",
        }[self.kind]
        pairs = (f", correlated by {number:g} with {path}" for path, number in self.correlated)
        varies = ", from part to part" if self.varies and self.kind != "list" else ""
        return f"{self.path}: {words}{''.join(pairs)}{varies}"


@dataclass(frozen=True, slots=True)
class Fixed:
    """An unknown input with a value that replaces its distribution."""

    unknown: Unknown
    value: float  # [SI]

    def __str__(self) -> str:
        return f"{self.unknown.path} is fixed at {self.unknown.text(self.value)}"


def without(unknown: Sequence[Unknown], paths: Collection[str]) -> tuple[Unknown, ...]:
    """Remove the inputs at `paths` from `unknown`, and correlations with them."""
    return tuple(
        replace(one, correlated=tuple(pair for pair in one.correlated if pair[0] not in paths))
        for one in unknown
        if one.path not in paths
    )


def drawn(unknown: tuple[Unknown, ...], seed: int, count: int) -> Array:
    """Draw `count` values of each unknown input [SI], shape (count, n_unknown)."""
    points = sequence(seed, count, max(MOST_INPUTS + 1, len(unknown)))
    return score_values(unknown, scipy.special.ndtri(points[:, : len(unknown)]))


def score_values(unknown: Sequence[Unknown], scores: Array) -> Array:
    """Values of unknown inputs [SI] at independent normal scores, both of shape (n, n_unknown).

    Correlations are a Gaussian copula. With the Cholesky factor L of the correlations, L Lᵀ = R,
    independent scores z become correlated scores L z. Each input keeps its own distribution
    (Nelsen, An Introduction to Copulas, 2006).
    """
    inside = np.clip(scores, -_OUTERMOST, _OUTERMOST)
    joint = inside @ np.linalg.cholesky(correlations(unknown)).T
    shares = scipy.special.ndtr(np.clip(joint, -_OUTERMOST, _OUTERMOST))
    columns = [one.quantile(row) for one, row in zip(unknown, shares.T, strict=True)]
    return np.array(columns, float).T.reshape(np.shape(scores))


def correlations(unknown: Sequence[Unknown]) -> Array:
    """Correlations of the normal scores of unknown inputs, shape (n_unknown, n_unknown)."""
    number = {one.path: i for i, one in enumerate(unknown)}
    matrix = np.eye(len(unknown))
    for i, one in enumerate(unknown):
        for path, correlation in one.correlated:
            matrix[i, number[path]] = matrix[number[path], i] = correlation
    return matrix


def first_unfit(correlations: Array) -> int | None:
    """Index of the first input whose correlations contradict earlier ones, or None."""
    for i in range(1, len(correlations)):
        before, last = correlations[:i, :i], correlations[i, :i]
        if 1 - last @ np.linalg.solve(before, last) < _LEAST:
            return i
    return None


def sequence(seed: int, count: int, dimensions: int = MOST_INPUTS + 1) -> Array:
    """Points (count, dimensions) of a scrambled Sobol' sequence, each coordinate within (0, 1)."""
    from scipy.stats import qmc  # takes 0.5 s, and few scenes need it

    sobol = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
    points: Array = sobol.random_base2(max(count - 1, 1).bit_length())[:count]
    return np.clip(points, _OFF_FACES, 1 - _OFF_FACES)
