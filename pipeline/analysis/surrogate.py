"""A polynomial in place of a simulation: least squares, judged by leaving out one sample at a time.

The logarithm of a rise is nearly linear in inputs on their natural scales (those of a log-normal
one: logarithms), so a plane or a quadric through some samples gives it anywhere. An input that is
one of a list has no scale; each of its values shifts the whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np

from pipeline.sweep.unknown import Unknown
from tribo import InputError
from tribo.types import Array

_SPARE = 1.5  # samples for each coefficient that a fit takes at least


@dataclass(frozen=True, slots=True, eq=False)
class Surrogate:
    """Functions of unknown inputs, as polynomials of them.

    Attributes
    ----------
    unknown : tuple of Unknown
        The inputs.
    degree : int
        1 for planes, 2 for quadrics, 0 for constants.
    coefficients : ndarray, shape (n_term, n_output)
        Coefficients of the terms, which `terms` gives.
    error : ndarray, shape (n_output,)
        Root mean square of what each sample misses if the fit leaves it out.
    explained : ndarray, shape (n_output,)
        Share of the variance that the fit explains of samples that it leaves out.
    """

    unknown: tuple[Unknown, ...]
    degree: int
    coefficients: Array
    error: Array
    explained: Array

    def __call__(self, inputs: Array) -> Array:
        """Values at inputs of shape (n, n_unknown); an array of shape (n, n_output)."""
        found: Array = terms(self.unknown, inputs, self.degree) @ self.coefficients
        return found


def fitted(unknown: Sequence[Unknown], inputs: Array, outputs: Array) -> Surrogate:
    """Fit planes or quadrics, whichever errs less where samples are left out.

    Parameters
    ----------
    unknown : sequence of Unknown
        The inputs.
    inputs : ndarray, shape (n, n_unknown)
        Values of the inputs.
    outputs : ndarray, shape (n, n_output)
        Values of the functions at them.

    Raises
    ------
    InputError
        If there are fewer samples than a plane needs.

    Examples
    --------
    >>> unknown = (Unknown("a.b", "uniform", (0.0, 1.0)), Unknown("c.d", "uniform", (0.0, 1.0)))
    >>> inputs = np.random.default_rng(0).random((40, 2))
    >>> found = fitted(unknown, inputs, (inputs[:, :1] * inputs[:, 1:] - inputs[:, :1]))
    >>> found.degree, bool(found.error[0] < 1e-12)
    (2, True)
    >>> print(f"{found(np.array([[0.5, 0.5]]))[0, 0]:.6f}")
    -0.250000
    """
    known = tuple(unknown)
    found = [_fit(known, inputs, outputs, degree) for degree in (1, 2) if known] or [
        _fit(known, inputs, outputs, 0)
    ]
    fits = [fit for fit in found if fit is not None]
    if not fits:
        needed = int(np.ceil(_SPARE * terms(known, inputs, 1).shape[1]))
        raise InputError(
            f"{len(inputs)} samples are too few for {len(known)} unknown inputs; give at least "
            f"{needed} as sweep.samples, and run the sweep again"
        )
    return min(fits, key=lambda fit: float(np.mean(fit.error**2)))


def redrawn(
    surrogate: Surrogate, inputs: Array, outputs: Array, count: int, seed: int
) -> list[Surrogate]:
    """Fits that other samples could have given: coefficients drawn about those of the fit.

    Each sample's part in them is scaled by a normal number times what the fit misses it by if it
    leaves it out (the wild bootstrap with residuals of the kind HC3, which errs to the safe side
    where samples are few).
    """
    columns = terms(surrogate.unknown, inputs, surrogate.degree)
    _, missed = _solved(columns, outputs)
    inverse, rng = np.linalg.pinv(columns), np.random.default_rng(seed)
    drawn = (rng.standard_normal((len(columns), 1)) for _ in range(count))  # one at a time
    shifts = (inverse @ (numbers * missed) for numbers in drawn)
    return [replace(surrogate, coefficients=surrogate.coefficients + each) for each in shifts]


def terms(unknown: Sequence[Unknown], inputs: Array, degree: int) -> Array:
    """Terms of a polynomial: 1, inputs on their scales, and their products of two for degree 2."""
    scaled, shifts = [], []
    for each, column in zip(unknown, inputs.T, strict=True):
        if each.kind == "list":
            shifts += [np.where(column == value, 1.0, 0.0) for value in each.parameters[1:]]
            continue
        low, high = each.at(np.array([0.1586553, 0.8413447]))
        values = np.log(column) if each.is_relative else column
        low, high = np.log([low, high]) if each.is_relative else (low, high)
        scaled.append((values - (low + high) / 2) / ((high - low) / 2))
    columns = [np.ones(len(inputs))]
    if degree >= 1:
        columns += [*scaled, *shifts]
    if degree >= 2:
        columns += [a * b for a, b in combinations_with_replacement(scaled, 2)]
    return np.stack(columns, axis=1)


def _fit(
    unknown: tuple[Unknown, ...], inputs: Array, outputs: Array, degree: int
) -> Surrogate | None:
    """A fit of one degree; None if there are too few samples for it."""
    columns = terms(unknown, inputs, degree)
    if degree and len(inputs) < _SPARE * columns.shape[1]:
        return None
    coefficients, missed = _solved(columns, outputs)
    error = np.sqrt(np.mean(missed**2, axis=0))
    variance = np.var(outputs, axis=0)
    # What is constant to rounding is explained.
    explained = 1 - error**2 / np.where(variance > 1e-24, variance, np.inf)
    return Surrogate(unknown, degree, coefficients, error, explained)


def _solved(columns: Array, outputs: Array) -> tuple[Array, Array]:
    """Coefficients by least squares, and what each sample misses if the fit leaves it out."""
    solution = np.linalg.lstsq(columns, outputs)
    coefficients: Array = solution[0].astype(float)
    if len(columns) == 1:
        return coefficients, np.zeros_like(outputs)
    basis, _, _ = np.linalg.svd(columns, full_matrices=False)
    leverage = np.sum(basis[:, : int(solution[2])] ** 2, axis=1)[:, None]
    missed: Array = (outputs - columns @ coefficients) / np.maximum(1 - leverage, 1e-12)
    return coefficients, missed
