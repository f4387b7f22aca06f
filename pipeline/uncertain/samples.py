"""Samples of a sweep whose inputs are not known exactly: the design of a computer experiment.

A sample is one velocity, and a value of each input that a rise depends on. Contacts depend on the
wear rate k and the velocity V only through w = kV. So consecutive samples share a contact: they
have the same w and different V. Samples fill the range evenly; they are not draws of the
distributions. If only the wear rate is unknown, values of w are planned: 8 even values with 2
velocities each predict the rise better than 128 samples on 8 random values.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np
import scipy  # its special functions take 0.2 s to load

from pipeline.sweep.conditions import PATHS
from pipeline.sweep.variants import PLACE_UNITS, ROWS, Column, Row, Variants, numbered_rows
from pipeline.uncertain.unknown import Fixed, Unknown, sequence, without
from tribo.types import Array

Layer = Literal["contact", "wear rate", "heat", "conditions"]
"""Part of a simulation that an input affects first."""

WIDENED = 1.4
"""Factor on normal scores, by which samples reach further than the inputs' distributions."""
REACH = 3.7
"""Largest normal score of a sample."""
SPECIFIC_WEAR_RATE = "wear.specific_wear_rate"
_RATES = 2.6  # largest normal score of the wear rates that share a contact
# Samples that share a contact: if an input changes the contact, else if the pin wears, else without
# wear.
_DRAWN, _PLANNED, _WITHOUT_WEAR = 4, 2, 64
_FOR_VELOCITY = 16  # samples that suffice for velocity and w; each further input doubles them
_OF_A_SURFACE = 2  # contacts that suffice for each value of a list, as values share a trend
JUDGED = 32
"""Contacts that cross-validation needs, to know to 5 % the share inside the 90 % bands."""


def samples_per_contact(layers: tuple[Layer, ...], wears: bool, separable: bool) -> int:
    """Number of samples that share a simulated contact, given what the unknown inputs affect.

    `layers` has the part of a simulation that each input affects. `separable` is True if a contact
    depends on the velocity only by the product of wear rate and velocity. `wears` is True if the
    pin wears.
    """
    if not separable:
        return 1
    if "contact" in layers:
        return _DRAWN
    return _PLANNED if wears else _WITHOUT_WEAR


@dataclass(frozen=True, slots=True)
class Design:
    """Rule that generates samples from a seed: their inputs, and the range of their velocities."""

    inputs: tuple[Unknown, ...]  # inputs that rises depend on, with the wear rate if it varies
    layers: tuple[Layer, ...]  # one for each input
    velocities: tuple[float, float]  # lowest and highest velocity [m/s]
    seed: int
    per_contact: int  # samples that share a contact

    @property
    def sufficient(self) -> int | None:
        """Number of samples above which more add nothing; None if more always help."""
        if self.per_contact == 1:
            return None
        of_contact = [
            one for one, layer in zip(self.inputs, self.layers, strict=True) if layer == "contact"
        ]
        if any(one.kind != "list" for one in of_contact):
            return None
        surfaces = math.prod(len(one.parameters) for one in of_contact)
        contacts = max(_OF_A_SURFACE * surfaces if of_contact else 0, JUDGED)
        others = sum(layer != "wear rate" for layer in self.layers)
        is_single = self.per_contact == _WITHOUT_WEAR  # then each row is left out alone
        return max(_FOR_VELOCITY << others, contacts * (1 if is_single else self.per_contact))

    def draw(self, count: int) -> tuple[Array, Array]:
        """Generate samples: their inputs [SI], (count, n_input), and velocities [m/s], (count,).

        The first samples are the same for any `count`. The velocities come from the first dimension
        of the Sobol' sequence, which is the most even one.
        """
        group = self.per_contact
        contacts = sequence(self.seed, -(-count // group)).repeat(group, axis=0)[:count]
        rows = sequence(self.seed + 2**31, count)
        columns = [
            one.quantile(_widen_shares(one, (rows if layer == "heat" else contacts)[:, i]))
            for i, (one, layer) in enumerate(zip(self.inputs, self.layers, strict=True), 1)
        ]
        place = np.arange(count) % group
        leads, stratum = place == 0, (place - 1 + rows[:, 0]) / max(group - 1, 1)
        low, high = np.log(self.velocities)
        first = low + (high - low) * contacts[:, 0]
        if "wear rate" in self.layers:
            # Samples that share a contact have velocities for which their wear rate is plausible.
            k = self.layers.index("wear rate")
            rate = self.inputs[k]
            least, most = np.log(rate.quantile(scipy.special.ndtr(np.array([-_RATES, _RATES]))))
            if "contact" in self.layers:
                number = np.log(columns[k]) + first
                low = np.minimum(np.maximum(low, number - most), first)
                high = np.maximum(np.minimum(high, number - least), first)
            else:
                number = low + least + _sum_quantiles(contacts[:, k + 1], high - low, most - least)
                low, high = np.maximum(low, number - most), np.minimum(high, number - least)
                leads, stratum = np.full(count, False), (place + rows[:, 0]) / group
        velocities = np.exp(np.where(leads, first, low + (high - low) * stratum))
        if "wear rate" in self.layers:
            columns[k] = np.where(leads, columns[k], np.exp(number) / velocities)
        return np.column_stack([*columns, velocities])[:, :-1], velocities


@dataclass(frozen=True, slots=True)
class Draw:
    """How samples are drawn: the unknown inputs, and the rule that generates the samples.

    `fixed` are inputs that are no longer unknown: a value replaces the distribution of each.
    """

    unknown: tuple[Unknown, ...]
    design: Design
    fixed: tuple[Fixed, ...] = ()  # inputs with a value instead of a distribution

    @classmethod
    def of(cls, data: Any) -> Draw:
        """Rebuild a `Draw` from the plain data of `as_dict`."""
        design = data["design"]
        lists = {"layers": tuple(design["layers"]), "velocities": tuple(design["velocities"])}
        inputs = tuple(map(Unknown.of, design["inputs"]))
        fixed = (Fixed(Unknown.of(one["unknown"]), one["value"]) for one in data["fixed"])
        unknown = tuple(map(Unknown.of, data["unknown"]))
        return cls(unknown, Design(**design | lists | {"inputs": inputs}), tuple(fixed))

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain data, ready for JSON."""
        data: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return data

    @property
    def open_inputs(self) -> dict[str, Unknown]:
        """Inputs to which `fixed_at` can give a value without a new simulation, by path.

        They are all unknown inputs, and those inputs in `fixed` whose value can still be changed.
        Such an input acts only after the simulation, as friction does, or its values differ between
        the samples.
        """
        movable = {*PATHS.values(), *(one.path for one in self.design.inputs)}
        stored = (one.unknown for one in self.fixed if one.unknown.path in movable)
        return {one.path: one for one in (*stored, *self.unknown)}

    def fixed_at(self, values: Mapping[str, float]) -> Draw:
        """Copy in which the inputs in `values` are fixed at these values [SI], by path.

        Paths that are not among `open_inputs` are ignored.
        """
        inputs = self.open_inputs
        new = {path: Fixed(inputs[path], value) for path, value in values.items() if path in inputs}
        fixed = {one.unknown.path: one for one in self.fixed} | new
        return replace(self, unknown=without(self.unknown, new), fixed=(*fixed.values(),))


def drawn_rows(draw: Draw, count: int) -> Variants:
    """Variants for `count` samples of a `draw`: a row with the inputs and velocity of each."""
    values, velocities = draw.design.draw(count)
    inputs, meaning = draw.design.inputs, "value of an input that is not known exactly"
    words = "sliding velocity of the sample"
    columns = (
        Column("sample", meaning=ROWS["sample"]),
        *(Column(one.path, one.unit, meaning=meaning) for one in inputs),
        Column("velocity", PLACE_UNITS["velocity"], meaning=words),
    )
    paths = [one.path for one in inputs]
    rows = (
        Row({"sample": k, **dict(zip(paths, row, strict=True)), "velocity": velocity}, {})
        for k, (row, velocity) in enumerate(zip(values.tolist(), velocities.tolist(), strict=True))
    )
    return numbered_rows(columns, rows, draw.as_dict())


def _sum_quantiles(shares: Array, one: float, other: float) -> Array:
    """Quantiles at `shares` of the sum of two independent uniform variables.

    One is distributed from 0 to `one`, and the other from 0 to `other`.
    """
    short, long = sorted((one, other))
    half = np.minimum(shares, 1 - shares)
    slope, middle = np.sqrt(2 * short * long * half), long * half + short / 2
    below = np.where(2 * long * half < short, slope, middle)
    total: Array = np.where(shares < 0.5, below, one + other - below)
    return total


def _widen_shares(unknown: Unknown, shares: Array) -> Array:
    """Move probabilities, `shares`, away from 0.5, so that samples reach further into the tails.

    Only a normal or log-normal input has tails; others are unchanged.
    """
    if unknown.kind not in ("normal", "log-normal"):
        return shares
    scores: Array = scipy.special.ndtr(
        np.clip(WIDENED * scipy.special.ndtri(shares), -REACH, REACH)
    )
    return scores
