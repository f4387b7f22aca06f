"""Kriging: predict a simulation's smooth outputs at inputs not simulated, with an error.

An output y of features u, here the logarithm of a temperature rise, is a Gaussian process about its
mean (Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006, Eqs. 2.25 and 2.26),

    k(u, u') = a² (1 + u·u') + b² (u·u')² + c² exp(−Σ (uᵢ − uᵢ')²/2ℓᵢ²) + s² [same contact] + n²,

with amplitudes a, b, c, s and n, and a length ℓᵢ for each input. The terms are a plane, a quadric,
a smooth departure, an effect shared by the samples with the same contact, and an effect of each
sample. The outputs at all loads share one kernel. Its constants maximise the likelihood (their Eq.
5.9). In cross-validation the constants are fitted without the samples left out. Otherwise the error
is underestimated, most of all with few contacts.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize
from scipy.special import ndtr

from pipeline.store.read import Keeper
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import worst_rises
from pipeline.uncertain.samples import JUDGED, SPECIFIC_WEAR_RATE, Design
from pipeline.uncertain.unknown import OF_90
from tribo.types import Array, Mask

_MOST_TO_FIT = 256  # rows used to fit the constants: n³ operations a step
# Up to this many rows each fold is fitted anew. With more, leaving a fold out hardly changes the
# constants.
_MOST_TO_LEAVE = 128
_FOLDS = 16
_BEGIN = np.log([0.1, 0.03, 0.05, 0.003, 0.002])  # initial a, b, c, s, n, for ln(rise)
_LENGTH = np.log(4.0)  # initial length ℓ of features whose spread is 1
_LEAST = np.log(1e-5)
_LEAST_OF_END = 1e-3  # lower limit of a relative input, over its upper end: draws may be ≤ 0

Groups = NDArray[np.intp]


END = 0.15
"""Part of the range of ln(velocity) at either end in which the error band is widened."""
_SHARE = 0.9  # nominal share of samples inside a band
_LEAST_SCORE = 1e-3  # least score, for outputs that are predicted exactly


@dataclass(frozen=True, slots=True, eq=False)
class Emulator:
    """Gaussian process that predicts outputs of a simulation from features of its inputs.

    It was fitted to n samples, with `features` (n, n_feature) and outputs (n, n_output).
    `dimensions` (n_feature,) has the number of the input that each feature belongs to. `constants`
    are logarithms of the kernel's five amplitudes, in the order of the module's equation, then of
    a length scale for each input.
    """

    features: Array  # (n, n_feature), with a spread of about 1
    dimensions: Groups  # number of the input that each feature belongs to; an input has one length
    mean: Array  # (n_output,)
    weights: Array  # (n, n_output), K⁻¹ (y − mean) with the kernel K between the rows
    constants: Array  # logarithms of a, b, c, s, n and the lengths ℓ
    whitener: Array  # (n, n), inverse of the Cholesky factor of the kernel between the rows
    check: LeftOut

    def __call__(self, features: Array, between: Array) -> tuple[Array, Array]:
        """Predict sums of outputs weighted by `between`, and their standard errors, both (n, m).

        `features` is (n, n_feature). The weights `between` (m, n_output) interpolate between the
        outputs, such as between loads. The standard errors are against a simulation.
        """
        smooth, _ = _kernel(features, self.features, self.dimensions, self.constants)
        outputs = (self.mean + smooth @ self.weights) @ between.T
        a, b, c, s, n = np.exp(2 * self.constants[:5])
        square = np.sum(features**2, axis=1)
        prior = a * (1 + square) + b * square**2 + c
        explained = np.sum((smooth @ self.whitener.T) ** 2, axis=1)
        shared = np.maximum(prior - explained, 0.0)[:, None]
        spread = np.sqrt(np.sum(between @ self.check.covariance * between, axis=1))
        return outputs, np.sqrt(shared + s + n) * spread


class LeftOut(NamedTuple):
    """Result of cross-validation of an emulator: its errors at samples left out of the fit.

    Samples with the same contact are left out together, one contact after the other. Then the
    samples at the lowest velocities are left out, and those at the highest. `held` is the share of
    samples inside their 90 % bands.
    """

    #: Covariance of the errors of outputs, over the predicted variance, (n_output, n_output). It is
    #: scaled so that 90 % bands hold 90 % of the samples left out.
    covariance: Array
    #: Further factor on the errors at the lowest and at the highest velocities. It is found by
    #: leaving out all samples of such an end.
    ends: float
    held: float  # share of samples inside the 90 % bands, each contact judged by the others
    contacts: int

    @property
    def error(self) -> float:
        """Standard error of the share of samples inside their 90 % bands, if the truth is 90 %."""
        return math.sqrt(_SHARE * (1 - _SHARE) / self.contacts)

    @property
    def is_known(self) -> bool:
        """True if there are enough contacts to estimate the share of samples inside their bands."""
        return self.contacts >= JUDGED

    @property
    def is_right(self) -> bool:
        """True if the share of samples inside their bands is known, and 85 to 95 % when rounded."""
        return self.is_known and 0.85 <= round(self.held, 2) <= 0.95


def fit_emulator(
    features: Array, dimensions: Groups, contacts: Groups, outputs: Array, keeper: Keeper | None
) -> Emulator:
    """Fit a Gaussian process to outputs (n, n_output), or read a fit that `keeper` has stored.

    `features` are (n, n_feature), a row for each sample. `dimensions` has the number of the input
    that each feature belongs to, and `contacts` the number of the contact of each sample.
    """
    mean = outputs.mean(axis=0)
    groups, parts = _folds(features[:, 0], contacts)
    part = slice(0, _MOST_TO_FIT)
    data = features[part], dimensions, contacts[part], (outputs - mean)[part]

    def leave_out() -> Array:
        rests = [~rows for rows in parts] if len(outputs) <= _MOST_TO_LEAVE else []
        fits = [data, *((features[one], dimensions, contacts[one], data[3][one]) for one in rests)]
        return np.array([_fit_constants(*fit) for fit in fits])

    constants, *without = load_or_compute(keeper, data, leave_out)
    solve = functools.partial(_solve_kernel, features, dimensions, contacts, outputs - mean)
    whitener, weights = solve(constants)
    check = _cross_validate(groups, parts, map(solve, without or [constants] * len(parts)))
    return Emulator(features, dimensions, mean, weights, constants, whitener, check)


def _solve_kernel(
    features: Array, dimensions: Groups, contacts: Groups, outputs: Array, constants: Array
) -> tuple[Array, Array]:
    """Inverse Cholesky factor of the covariance K of the samples' outputs, and K⁻¹ × outputs.

    `outputs` (n, n_output) belong to the rows of `features` (n, n_feature). `dimensions` has the
    number of the input that each feature belongs to, and `contacts` the number of the contact of
    each row. `constants` are logarithms of the kernel's five amplitudes, then of a length for each
    input.
    """
    smooth, _ = _kernel(features, features, dimensions, constants)
    factor = cho_factor(_row_kernel(smooth, contacts, constants), lower=True)
    whitener = solve_triangular(factor[0], np.eye(len(outputs)), lower=True)
    return whitener, cho_solve(factor, outputs)


def features_of(
    design: Design, columns: Sequence[Array] | Array, velocities: Array
) -> tuple[Array, Groups]:
    """Features (n, n_feature) with a spread of about 1, and the input that each belongs to.

    The first feature is ln(velocity), and belongs to input 0. `columns` has the values (n,) of each
    further input of `design`. The feature of a wear rate is ln(wear rate × velocity).
    """
    low, high = np.log(design.velocities)
    spread = (high - low) / math.sqrt(12)
    along = (np.log(velocities) - (low + high) / 2) / spread
    features, dimensions = [along], [0]
    for number, (quantity, column) in enumerate(zip(design.inputs, columns, strict=True), 1):
        is_rate = quantity.path == SPECIFIC_WEAR_RATE
        if quantity.kind == "list" and not is_rate:
            features += [np.where(column == value, 1.0, 0.0) for value in quantity.parameters]
            dimensions += [number] * len(quantity.parameters)
            continue
        values, ends = column, quantity.quantile(ndtr(np.array([-1.0, 1.0])))
        if quantity.is_relative or is_rate:
            values, ends = np.log(np.maximum(values, _LEAST_OF_END * ends.max())), np.log(ends)
        scaled, width = values - ends.mean(), float(ends[1] - ends[0]) / 2
        if is_rate:
            scaled, width = scaled + spread * along, math.hypot(width, spread)
        features.append(scaled / width)
        dimensions.append(number)
    return np.stack(features, axis=1), np.array(dimensions)


def _kernel(
    one: Array, other: Array, dimensions: Groups, constants: Array
) -> tuple[Array, tuple[Array, ...]]:
    """Smooth covariance of outputs between two sets of features (n, m), and its three terms (n, m).

    The terms between features u and v are a² (1 + u·v), b² (u·v)² and c² exp(−Σ (uᵢ − vᵢ)²/2ℓᵢ²).
    `one` (n, n_feature) and `other` (m, n_feature) are the two sets. `dimensions` (n_feature,) has
    the number of the input that each feature belongs to. `constants` are ln a, ln b and ln c,
    logarithms of two amplitudes that are not used here, then ln ℓ of each input.
    """
    a, b, c = np.exp(2 * constants[:3])
    lengths = np.exp(constants[5:])[dimensions]
    product = one @ other.T
    u, v = one / lengths, other / lengths
    distance = np.sum(u**2, axis=1)[:, None] + np.sum(v**2, axis=1) - 2 * u @ v.T
    terms = a * (1 + product), b * product**2, c * np.exp(-0.5 * np.maximum(distance, 0.0))
    return terms[0] + terms[1] + terms[2], terms


def _row_kernel(smooth: Array, contacts: Groups, constants: Array) -> Array:
    """Covariance (n, n) of training rows: smooth part, random effect of each contact, and noise.

    `smooth` (n, n) is the smooth part, from `_kernel`. `contacts` has the number of the contact of
    each row. `constants` are logarithms of the kernel's five amplitudes, of which the last two are
    used here, then of a length for each input.
    """
    s, n = np.exp(2 * constants[3:5])
    kernel: Array = smooth + s * (contacts[:, None] == contacts)
    kernel[np.diag_indices_from(kernel)] += n
    return kernel


def _fit_constants(features: Array, dimensions: Groups, contacts: Groups, outputs: Array) -> Array:
    """Fit the kernel's constants: maximum of the posterior density under a weak prior.

    The constants are logarithms of five amplitudes, then of a length for each input. `features` (n,
    n_feature) and `outputs` (n, n_output) have a row for each sample. The mean over samples is
    already subtracted from `outputs`. `dimensions` (n_feature,) has the number of the input that
    each feature belongs to, and `contacts` (n,) the number of the contact of each sample.
    """
    count = int(dimensions.max(initial=-1)) + 1
    middle = np.concatenate([_BEGIN, np.full(count, _LENGTH)])
    spread = np.concatenate([np.full(5, 3.0), np.full(count, 1.0)])  # spread of a weak prior
    differences = [
        sum(np.subtract.outer(column, column) ** 2 for column in features.T[dimensions == i])
        for i in range(count)
    ]
    same = contacts[:, None] == contacts
    rows, n_output = outputs.shape

    def loss(constants: Array) -> tuple[float, Array]:
        smooth, (plane, quadric, departure) = _kernel(features, features, dimensions, constants)
        factor = cho_factor(_row_kernel(smooth, contacts, constants), lower=True)
        weights = cho_solve(factor, outputs)
        off = (constants - middle) / spread
        value = 0.5 * np.sum(weights * outputs) + n_output * np.log(np.diag(factor[0])).sum()
        inner = weights @ weights.T - n_output * cho_solve(factor, np.eye(rows))
        inside = departure * inner
        slopes = [
            np.sum(plane * inner), np.sum(quadric * inner), np.sum(inside),
            np.exp(2 * constants[3]) * np.sum(inner[same]),
            np.exp(2 * constants[4]) * np.trace(inner),
            *(0.5 * np.sum(inside * d) / np.exp(2 * e)
              for d, e in zip(differences, constants[5:], strict=True)),
        ]  # fmt: skip
        return float(value + 0.5 * np.sum(off**2)), off / spread - np.array(slopes)

    bounds = [(_LEAST, 3.0)] * 5 + [(-2.0, 5.0)] * count
    best: Array = minimize(loss, middle, jac=True, method="L-BFGS-B", bounds=bounds).x
    return best


def band_factor(scores: Array, count: int) -> float:
    """Factor on standard errors that makes 90 % bands hold 90 % of new samples.

    `scores` are errors of samples divided by predicted errors, in `count` independent groups. The
    factor is a quantile of their size over 1.645: the next group stays below this quantile with
    90 % probability (Dunn, Wasserman & Ramdas, J. Am. Stat. Assoc. 118, 2491, 2023). With too few
    groups for it, the largest size replaces the quantile, and the factor is at least 1.
    """
    if count < 1:
        return 1.0
    share = _SHARE * (count + 1) / count
    found = float(np.quantile(np.abs(scores), min(share, 1.0))) / OF_90
    return max(found, 1.0) if share > 1 else found


def end_weight(along: Array) -> Array:
    """Weight of the errors at the ends of a range of ln(velocity): 1 at both ends, 0 in the middle.

    `along` is the position in the range, from 0 to 1.
    """
    return np.asarray(np.clip((np.abs(2 * along - 1) - (1 - 2 * END)) / (2 * END), 0.0, 1.0))


def _folds(velocities: Array, contacts: Groups) -> tuple[Groups, list[Mask]]:
    """Number of the group of each row, and masks of rows to leave out in cross-validation.

    The rows of a contact are a group; with a single contact, each row is a group. There is a
    mask for each fold of groups, a mask of rows at the lowest velocities, and a mask of rows at the
    highest velocities. `contacts` has the number of the contact of each row. `velocities` are
    ln(velocity), scaled to mean 0 and standard deviation 1 over the range of velocities.
    """
    is_single = (contacts == contacts[0]).all()
    _, groups = np.unique(np.arange(len(contacts)) if is_single else contacts, return_inverse=True)
    folds = groups % _FOLDS
    along = velocities / (2 * math.sqrt(3.0)) + 0.5
    parts = [folds == one for one in range(int(folds.max()) + 1)]
    return groups, [*parts, along < END, along > 1 - END]


def _cross_validate(
    groups: Groups, parts: Sequence[Mask], solutions: Iterable[tuple[Array, Array]]
) -> LeftOut:
    """Summarise cross-validation: errors of rows that were predicted from the other rows.

    `groups` and `parts` are those of `_folds`: the number of the group of each row, and masks of
    the rows left out together. `solutions` has a result of `_solve_kernel` for each mask, computed
    on all rows with the kernel's constants for that mask.
    """
    *folds, low, high = zip(parts, solutions, strict=True)
    count = int(groups.max()) + 1
    scores = np.empty_like(low[1][1])
    for rows, (whitener, weights) in folds:
        inverse = whitener.T @ whitener
        for one in np.unique(groups[rows]):
            scores[groups == one] = _left_out_errors(inverse, weights, groups == one)
    factors = _band_factors(scores, count)
    spread = np.maximum(np.sqrt(np.mean(scores**2, axis=0)), _LEAST_SCORE)
    together = np.mean((scores / spread)[:, :, None] * (scores / spread)[:, None], axis=0)
    # Each contact is judged with factors found from all other contacts.
    limits = OF_90 * np.array([_band_factors(scores[groups != k], count - 1) for k in range(count)])
    is_inside = np.abs(scores) <= limits[groups]
    at_ends = [
        _left_out_errors(whitener.T @ whitener, weights, rows) / factors
        for rows, (whitener, weights) in (low, high)
        if rows.any()
    ]
    widening = 1.0
    if at_ends:
        widening = max(1.0, band_factor(np.concatenate(at_ends), sum(map(len, at_ends))))
    covariance = np.outer(factors, factors) * together
    return LeftOut(covariance, widening, float(np.mean(is_inside)), count)


def _band_factors(scores: Array, count: int) -> Array:
    """Factors (n_output,) on standard errors that make 90 % bands hold 90 % of new samples.

    `scores` (n, n_output) are errors divided by predicted errors, in `count` independent groups.
    """
    return np.maximum([band_factor(one, count) for one in scores.T], _LEAST_SCORE)


def _left_out_errors(inverse: Array, weights: Array, rows: Mask) -> Array:
    """Errors of rows that are left out together, divided by predicted errors, (n_row, n_output).

    With the inverse C of the kernel and the outputs y, the error is C_II⁻¹ (C y)_I, and its
    covariance is C_II⁻¹ (Rasmussen & Williams, Sec. 5.4.2, for several rows). `weights` are C y,
    and `rows` is I.
    """
    covariance = np.linalg.inv(inverse[np.ix_(rows, rows)])
    missed: Array = covariance @ weights[rows] / np.sqrt(np.diag(covariance))[:, None]
    return missed


_BEND = 0.02  # curvature error of ln(rise) between two loads: ten times that of a shipped scene


def load_weights(loads: Array, rises: Array, load: float) -> tuple[Array, float]:
    """Weights (n_load,) that interpolate ln(rise) to `load` [N], and the interpolation's error.

    The error is a standard deviation of ln(rise). `rises` (n, n_load) are the temperature rises of
    all samples at `loads` [N].
    """
    x, place = np.log(loads), math.log(load)
    if len(x) == 1:
        return np.ones(1), 0.0
    if len(x) == 2:
        weights = _spline(x, place, 1)
        return weights, _BEND * 2 * math.sqrt(max(float(weights[0] * weights[1]), 0.0))
    weights, linear = _spline(x, place, min(3, len(x) - 1)), _spline(x, place, 1)
    rough = linear
    if len(x) > 3:
        near = np.sort(np.argsort(np.abs(x - place))[:3])
        rough = np.zeros(len(x))
        rough[near] = _spline(x[near], place, 2)
    off = np.log(rises) @ (weights - rough)
    # Each load also has a random part of its own, which its neighbours do not predict.
    own = _spread_between_nodes(x, np.log(rises)) * math.sqrt(2 * max(1 - np.sum(linear**2), 0.0))
    return weights, float(np.hypot(np.sqrt(np.mean(off**2)), own))


def _spread_between_nodes(x: Array, values: Array) -> float:
    """Standard deviation of values (n, n_load) from straight lines between their neighbours.

    The part that is due to the scatter of the neighbours is removed. `x` (n_load,) are the
    abscissae.
    """
    found = []
    for number in range(1, len(x) - 1):
        beside = [number - 1, number + 1]
        weights = _spline(x[beside], x[number], 1)
        missed = values[:, number] - values[:, beside] @ weights
        found.append(np.var(missed) / (1 + np.sum(weights**2)))
    return math.sqrt(np.mean(found))


def _spline(x: Array, place: float, degree: int) -> Array:
    """Weights (n,) of the values at nodes `x` that give the value of their spline at `place`.

    `place` is an abscissa, and `degree` the degree of the spline.
    """
    return np.asarray(make_interp_spline(x, np.eye(len(x)), k=degree)(place))


_RULE = b"2"  # change this whenever the computation of the numbers changes


def load_or_compute(
    keeper: Keeper | None, data: Sequence[Array | Any], find: Callable[[], Array]
) -> Array:
    """Numbers that `find` computes from `data`, or that the store has kept from an earlier call.

    `keeper` is the store's cache, which also keeps new numbers; None for no store.
    """
    if keeper is None:
        return find()
    name = f"fit-{_hash(_RULE, *(np.ascontiguousarray(one).tobytes() for one in data))[:16]}"
    numbers = load_numbers(keeper, name)
    if numbers is None:
        numbers = find().tolist()
        document = {"numbers": numbers, "hash": _hash(json.dumps(numbers).encode())}
        keeper.keep(name, json.dumps(document).encode())
    return np.array(numbers, float)


def load_numbers(keeper: Keeper, name: str) -> Any:
    """Numbers that a store's cache has kept as `name`; None if missing or damaged."""
    with suppress(ValueError, KeyError, TypeError, RecursionError):
        document = json.loads(keeper.kept(name) or b"")
        if document["hash"] == _hash(json.dumps(document["numbers"]).encode()):
            return document["numbers"]
    return None


def _hash(*parts: bytes) -> str:
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def columns_until(
    columns: Mapping[str, Array], loads: Array, hold: float, done: Mask
) -> dict[str, Array] | None:
    """Copy `columns` with a normal load of NaN at steps later than `hold` [s] after full load.

    The criterion ignores steps whose normal load is NaN. `columns` has the results of load steps:
    arrays (n_sample, n_load, n_step) by the name of the variable. `loads` (n_load,) are the full
    loads [N]. `done` (n_sample,) is True for samples computed at all loads. Returns None if one of
    these samples has no temperature `hold` seconds after reaching a full load.
    """
    time, normal_load = columns["time"], columns["normal_load"]
    reached = np.where(normal_load >= loads[:, None], time, np.inf).min(axis=-1, keepdims=True)
    since = time - reached
    is_end = np.isclose(since, hold, rtol=1e-6, atol=1e-9) & np.isfinite(columns["mean_rise"])
    if not is_end.any(axis=-1)[done].all():
        return None
    is_later = since > hold * (1 + 1e-6) + 1e-9
    return {**columns, "normal_load": np.where(is_later, np.nan, normal_load)}


def decisive_rises(
    columns: Mapping[str, Array], loads: Array, conditions: Sequence[Conditions]
) -> Array:
    """Temperature rises that the criterion compares with its limit, by sample and load.

    The rises [K] are per unit friction coefficient, (n_sample, n_load). `columns` has results of
    load steps, (n_sample, n_load, n_step), by the name of the variable. `loads` are the full loads
    [N], and `conditions` has the criterion and the corrections of each sample.
    """
    rows = [
        worst_rises({name: values[i] for name, values in columns.items()}, loads[:, None], one)
        for i, one in enumerate(conditions)
    ]
    return np.array(rows)
