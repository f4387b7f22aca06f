"""Correlations of unknown inputs: the key ``correlated`` of their distributions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.scene.faults import Faults, did_you_mean, quoted
from pipeline.scene.schema import Shape
from pipeline.sweep.unknown import Unknown, correlations
from tribo.types import Array

_LEAST = 1e-6  # of the variance of an input's score that the others must leave open


def with_correlations(
    unknown: tuple[Unknown, ...], table: Mapping[str, Shape], faults: Faults
) -> tuple[Unknown, ...]:
    """Unknown inputs, each with its correlations with those that stand before it in the file."""
    order = {one.path: number for number, one in enumerate(unknown)}
    pairs: dict[tuple[int, int], tuple[str, float]] = {}
    stated = [
        (f"unknown.{quoted(path)}.correlated.{quoted(other)}", path, other, correlation)
        for path, shape in table.items()
        for other, correlation in shape.correlated.items()
    ]
    for key, path, other, correlation in stated:
        if other not in table or other == path:
            hint = did_you_mean(other, [name for name in table if name != path])
            faults.note(key, f"this is not another input of [unknown]{hint}")
        elif not {path, other} <= set(order):
            continue  # one of them is faulty
        elif unknown[order[other]].kind == "list":
            problem = "each value of a list is as likely, whatever else is; give a distribution"
            faults.note(key, problem)
        else:
            pair = max(order[path], order[other]), min(order[path], order[other])
            _, before = pairs.setdefault(pair, (key, correlation))
            if before != correlation:
                faults.note(key, f"{correlation:g} is {before:g} elsewhere; give it once")
    joint = [list[tuple[str, float]]() for _ in unknown]
    for (later, earlier), (_, correlation) in sorted(pairs.items()):
        if correlation:
            joint[later].append((unknown[earlier].path, correlation))
    inputs = tuple(
        replace(one, correlated=tuple(others)) for one, others in zip(unknown, joint, strict=True)
    )
    _check_fit(inputs, pairs, faults)
    return inputs


def _check_fit(
    unknown: tuple[Unknown, ...], pairs: Mapping[tuple[int, int], tuple[str, float]], faults: Faults
) -> None:
    """Note the correlation that the others do not allow, if there is one."""
    matrix = correlations(unknown)
    if (i := first_unfit(matrix)) is None:
        return
    concerned = [pair for pair in pairs if pair[0] == i]
    for pair in reversed(concerned):
        if ends := allowed(matrix, *pair):
            key, correlation = pairs[pair]
            low, high = math.ceil(1000 * ends[0]) / 1000, math.floor(1000 * ends[1]) / 1000
            faults.note(
                key,
                f"{correlation:g} cannot be, beside what else is correlated; give {low:g} to "
                f"{high:g}, or other correlations",
            )
            return
    faults.note(
        pairs[concerned[-1]][0],
        "the correlations of this input cannot all be; give smaller ones, or leave one out",
    )


def first_unfit(correlations: Array) -> int | None:
    """Number of the first input whose stated correlations with those before it are impossible."""
    for i in range(1, len(correlations)):
        before, last = correlations[:i, :i], correlations[i, :i]
        if 1 - last @ np.linalg.solve(before, last) < _LEAST:
            return i
    return None


def allowed(correlations: Array, i: int, j: int) -> tuple[float, float] | None:
    """Lowest and highest correlation of an input with one before it, given all others, if any."""
    inverse = np.linalg.inv(correlations[:i, :i])
    others = correlations[i, :i].copy()
    others[j] = 0.0
    last = others @ inverse @ others - (1 - _LEAST)
    roots = np.sort(np.roots([inverse[j, j], 2 * inverse[j] @ others, last]))
    return None if np.iscomplexobj(roots) else (float(roots[0]), float(roots[1]))
