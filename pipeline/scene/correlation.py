"""Reads which unknown inputs are correlated: the key ``correlated`` of their distributions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from pipeline.scene.entries import did_you_mean, quoted
from pipeline.scene.faults import Fault
from pipeline.sweep.correlation import allowed, first_unfit
from pipeline.sweep.unknown import Unknown, correlations


def with_correlations(
    unknown: tuple[Unknown, ...], table: Mapping[str, Any], faults: list[Fault]
) -> tuple[Unknown, ...]:
    """Unknown inputs, each with its correlations with those that stand before it.

    Parameters
    ----------
    unknown : tuple of Unknown
        Inputs in the order of the file.
    table : mapping
        The table ``[unknown]`` as the format gives it.
    faults : list of Fault
        List to which every fault found is added.
    """
    order = {each.path: number for number, each in enumerate(unknown)}
    given: dict[tuple[int, int], tuple[str, float]] = {}
    for key, path, other, correlation in _given(table):
        if other not in table or other == path:
            others = [each for each in table if each != path]
            problem = f"this is not another input of [unknown]{did_you_mean(other, others)}"
            faults.append(Fault(key, problem))
            continue
        if not {path, other} <= set(order):
            continue  # one of them is faulty
        if unknown[order[other]].kind == "list":
            problem = "each value of a list is as likely, whatever else is; give a distribution"
            faults.append(Fault(key, problem))
            continue
        pair = max(order[path], order[other]), min(order[path], order[other])
        _, known = given.setdefault(pair, (key, correlation))
        if known != correlation:
            faults.append(Fault(key, f"{correlation:g} is {known:g} elsewhere; give it once"))
    found = tuple(
        replace(
            each,
            correlated=tuple(
                (other.path, given[i, j][1])
                for j, other in enumerate(unknown[:i])
                if given.get((i, j), ("", 0.0))[1]
            ),
        )
        for i, each in enumerate(unknown)
    )
    faults += _unfit(found, given)
    return found


def _given(table: Mapping[str, Any]) -> Iterator[tuple[str, str, str, float]]:
    """Key path of each correlation in the file, the two inputs, and the number."""
    for path, value in table.items():
        if isinstance(value, Mapping):
            for other, correlation in value["correlated"].items():
                key = f"unknown.{quoted(path)}.correlated.{quoted(other)}"
                yield key, path, other, correlation


def _unfit(
    unknown: tuple[Unknown, ...], given: Mapping[tuple[int, int], tuple[str, float]]
) -> Iterator[Fault]:
    """The correlation that the others do not allow, if there is one."""
    known = correlations(unknown)
    if (i := first_unfit(known)) is None:
        return
    pairs = [pair for pair in given if pair[0] == i]
    for pair in reversed(pairs):
        if ends := allowed(known, *pair):
            key, correlation = given[pair]
            low, high = math.ceil(1000 * ends[0]) / 1000, math.floor(1000 * ends[1]) / 1000
            yield Fault(
                key,
                f"{correlation:g} cannot be, beside what else is correlated; give {low:g} to "
                f"{high:g}, or other correlations",
            )
            return
    yield Fault(
        given[pairs[-1]][0],
        "the correlations of this input cannot all be; give smaller ones, or leave one out",
    )
