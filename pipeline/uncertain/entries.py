"""Read the table ``[unknown]`` of a scene, and extend its sweep with samples of these inputs.

A sample is read as if its values stood in the scene file. Each distribution is checked at its ends.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import scipy  # its special functions take 0.2 s to load

from pipeline.quantities import DIMENSIONS, as_written
from pipeline.scene.document import Document
from pipeline.scene.extensions import Extend
from pipeline.scene.faults import Faults, did_you_mean, quoted
from pipeline.scene.units import UnitError, difference_in_si, si_unit, to_si
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.tables import CURVES, entry_at, flat, replace_values
from pipeline.sweep.variants import Variants
from pipeline.uncertain.format import UNKNOWN, StatedDistribution
from pipeline.uncertain.samples import (
    REACH,
    SPECIFIC_WEAR_RATE,
    Design,
    Draw,
    Layer,
    drawn_rows,
    samples_per_contact,
)
from pipeline.uncertain.unknown import (
    MOST_INPUTS,
    Fixed,
    Form,
    Unknown,
    correlations,
    first_unfit,
    without,
)
from tribo import InputError, Wear
from tribo.simulation import inseparable, mechanics

_CHECKED_AT_ONCE = 1000  # samples checked when a scene is read; later ones when computed
_FACTOR = 1.25  # spread of wear rates within a contact if the scene's wear rate is known
_FIXED = (
    "sweep", "fidelity", "window", "measured", "tested", "unknown", "title", "extends", "without",
)  # fmt: skip
_SIGNS = {"degC": "°C", "um": "µm"}
# Path of the failing share, and unit of wear rates.
_SHARE, _OF_RATE = "temperature.failing_share", "m2 N-1"
_APPLIED = {"friction.coefficient", "temperature.bulk", "temperature.critical"}


def _fixed_paths(document: Document) -> frozenset[str]:
    """Paths of unknown inputs to which an overriding layer of the scene gives a value.

    Such a layer is ``--set``, or a scene file that extends the file with the unknown input.
    """
    fixed, above, seen = set[str](), set[str](), set[str]()
    for layer in document.layers:
        table = layer.entries.get("unknown")
        unknown = {path for path, _ in UNKNOWN.leaves(table)} if isinstance(table, dict) else set()
        fixed |= (unknown - seen) & above
        seen |= unknown
        above |= {path for path, _ in flat(layer.entries)}
    return frozenset(fixed)


def begin(document: Document, faults: Faults) -> tuple[Document, Extend]:
    """Return the scene file unchanged, and the function that adds samples to its sweep."""
    return document, partial(_extend, _fixed_paths(document), faults)


def _extend(fixed: Collection[str], faults: Faults, sweep: Sweep) -> Sweep:
    """Add samples to each variant of a sweep.

    The sweep is returned unchanged if no number of samples is given, no input is unknown, or faults
    are found here. `fixed` are paths of unknown inputs to which the scene also gives a value.
    Faults and notes are added to `faults`. Raises an `InputError` if samples are impossible, such
    as a number of samples without unknown inputs.
    """
    scene = sweep.declared
    count, unknown = scene.sweep.samples, scene.unknown or {}
    if count is not None and not set(unknown) - set(fixed):
        raise InputError(
            f"sweep.samples: {count} needs unknown inputs, and the scene has none; add [unknown], "
            "or leave out sweep.samples"
        )
    if not unknown:
        return sweep
    before = len(faults)
    if sweep.scene.unequal_bulks:
        raise InputError(
            "temperature.bulk: [unknown] needs one bulk temperature for both bodies, because its "
            "probabilities scale the whole rise by friction: give one, or leave out [unknown] "
            "and use irg vary"
        )
    inputs, known = _read_inputs(scene, fixed, faults)
    for one in known:
        faults.note("unknown", f"{one}, because the scene also gives a value")
    if len(inputs) > MOST_INPUTS:
        faults.refuse("unknown", f"{len(inputs)} inputs are unknown; give {MOST_INPUTS} at most")
    layers = [_first_affected_part(one, sweep, faults) for one in inputs]
    if len(faults) > before:
        return sweep
    if count is None:
        faults.note("unknown", f"inputs: {len(inputs)}; give sweep.samples to draw them")
        return sweep
    if sweep.conditions.critical_sd:
        raise InputError(
            "temperature.critical_sd: sweep.samples ignores this; leave it out, and give "
            '"temperature.critical" with mean and sd in [unknown]'
        )
    design = _design(inputs, layers, scene.sweep.sample_seed or 0, sweep)
    if any(column.is_drawn for column in sweep.variants.columns):
        raise InputError(
            "sweep.realizations: sweep.samples excludes them; make the surface an unknown input: "
            '"disk.roughness.seed" = [0, 1, 2, 3]'
        )
    if design.sufficient and count > design.sufficient:
        count = design.sufficient
        faults.note("sweep.samples", f"{count} are computed: more would share their contacts")
    return _add_samples(Draw(inputs, design, known), count, sweep)


def _read_inputs(
    scene: Any, fixed: Collection[str], faults: Faults
) -> tuple[tuple[Unknown, ...], tuple[Fixed, ...]]:
    """Read the scene's table ``[unknown]``: inputs that are unknown, and inputs that are fixed.

    An input is fixed if its path is in `fixed`: the scene's value replaces the distribution.
    Faulty distributions are added to `faults`, and left out.
    """
    table, inputs = scene.unknown, []
    for path, shape in table.items():
        with faults.at(f"unknown.{quoted(path)}"):
            one = _read_input(path, shape.form, shape.parameters)
            varies = shape.varies or path.endswith(".seed")
            inputs.append(replace(one, varies=varies))
    joint = _add_correlations(inputs, table, faults)
    known = tuple(Fixed(one, entry_at(scene, one.path)) for one in joint if one.path in fixed)
    return without(joint, fixed), known


def _add_correlations(
    unknown: Sequence[Unknown], table: Mapping[str, StatedDistribution], faults: Faults
) -> tuple[Unknown, ...]:
    """Copy unknown inputs, and add to each its correlations with earlier inputs in `table`.

    `table` is the scene's table ``[unknown]``. Contradictions are added to `faults`.
    """
    order = {one.path: number for number, one in enumerate(unknown)}
    varying = {one.path: None if one.kind == "list" else one.varies for one in unknown}
    # Correlation and key of each pair, by the numbers of its inputs, the later one first.
    pairs = dict[tuple[int, int], tuple[float, str]]()
    stated = [(path, *pair) for path, shape in table.items() for pair in shape.correlated.items()]
    for path, other, correlation in stated:
        key = f"unknown.{quoted(path)}.correlated.{quoted(other)}"
        if other not in table or other == path:
            hint = did_you_mean(other, [name for name in table if name != path])
            faults.refuse(key, f"this is not another input of [unknown]{hint}")
        elif not {path, other} <= set(order):
            continue  # one of the two inputs is faulty, and already reported
        elif varying[other] is None or varying[path] != varying[other]:
            problem = "a list cannot be correlated, nor can inputs that differ in `varies`"
            faults.refuse(key, f"{problem}; leave this entry out")
        else:
            earlier, later = sorted((order[path], order[other]))
            before, _ = pairs.setdefault((later, earlier), (correlation, key))
            if before != correlation:
                faults.refuse(key, f"{correlation:g} is {before:g} elsewhere; give it once")
    joint = list(unknown)
    for (later, earlier), (correlation, _) in sorted(pairs.items()):
        if correlation:
            own = *joint[later].correlated, (unknown[earlier].path, correlation)
            joint[later] = replace(joint[later], correlated=own)
    if (i := first_unfit(correlations(joint))) is not None:
        *_, key = (key for (later, _), (_, key) in pairs.items() if later == i)
        problem = "the correlations of this input contradict each other; give smaller ones"
        faults.refuse(key, f"{problem}, or leave one out")
    return tuple(joint)


def _design(inputs: Sequence[Unknown], layers: list[Layer], seed: int, sweep: Sweep) -> Design:
    """Make the rule that generates the samples, from the unknown inputs and the sweep's velocities.

    `layers` has for each input the first part of a simulation that it affects, such as the contact.
    The design leaves out inputs that act only after the simulation. It varies a known wear rate, so
    that samples share contacts. Raises an `InputError` with fewer than two velocities above 0, or
    without friction.
    """
    moving = [velocity for velocity in sweep.plane.velocities if velocity > 0]
    if len(moving) < 2 or not sweep.scene.friction_heat:
        raise InputError(
            "sweep.velocities: samples lie between the lowest and the highest velocity; give at "
            "least two above 0, and friction"
        )
    ends = moving[0], moving[-1]
    separable = inseparable(sweep.scene, ends) is None
    pairs = zip(inputs, layers, strict=True)
    drawn = [(one, layer) for one, layer in pairs if layer != "conditions"]
    rate = sweep.scene.wear.specific_wear_rate if isinstance(sweep.scene.wear, Wear) else 0.0
    if separable and rate and "wear rate" not in layers:
        terms = (rate, _FACTOR)
        spread = Unknown(SPECIFIC_WEAR_RATE, "log-normal", terms, _OF_RATE, "mm³/(N m)")
        drawn.append((spread, "wear rate"))
    if not separable:
        drawn = [(one, "contact" if layer != "heat" else layer) for one, layer in drawn]
    unknown, kinds = tuple(one for one, _ in drawn), tuple(layer for _, layer in drawn)
    group = samples_per_contact(kinds, rate > 0, separable)
    return Design(unknown, kinds, ends, seed, group)


def _add_samples(draw: Draw, count: int, sweep: Sweep) -> Sweep:
    """Copy of the sweep with `count` samples for each variant, generated by `draw`.

    Raises an `InputError` if one of the first 1000 variants is not a valid scene.
    """
    made = replace(sweep, variants=sweep.variants * drawn_rows(draw, count))
    try:
        for name in made.variants.names[:_CHECKED_AT_ONCE]:
            _ = made.variant(name).parts
    except InputError as error:
        raise InputError(
            f"unknown: a sample is not a sound scene: {error}; give narrower distributions"
        ) from error
    return made


def _read_input(path: str, kind: Form, parameters: tuple[Any, ...]) -> Unknown:
    """Read the distribution of one input from its form and `parameters`.

    Raises a `UnitError` or `InputError` if the distribution is faulty.
    """
    if path.partition(".")[0] in _FIXED or "." not in path:
        raise InputError(
            "this cannot be unknown; give an entry that affects temperature or wear, such as "
            '"wear.specific_wear_rate" or "temperature.critical"'
        )
    first, *others = parameters
    is_text = isinstance(first, str)
    if kind != "log-normal" and any(isinstance(other, str) != is_text for other in others):
        raise UnitError(f"{', '.join(map(quoted, parameters))}: give all with a unit, or none")
    if not is_text:
        return Unknown(path, kind, tuple(map(float, parameters)))
    in_si = {"log-normal": float, "normal": lambda text: difference_in_si(text, first)}
    convert = in_si.get(kind, lambda text: to_si(text, first))
    values = to_si(first, first), *map(convert, others)
    if (si := si_unit(first)) not in DIMENSIONS:
        raise UnitError(f'{quoted(first)}: give one such as "2 mm", or plain numbers')
    unit, units = first.strip().partition(" ")[2], DIMENSIONS[si].units
    shown = _SIGNS.get(unit, unit) if unit in units else next(iter(units))
    return Unknown(path, kind, values, si, shown)


def _first_affected_part(one: Unknown, sweep: Sweep, faults: Faults) -> Layer:
    """Find the first part of a simulation that an input affects, by trying extreme values.

    The part is "contact", "wear rate" or "heat"; "conditions" if the input acts only afterwards, or
    is faulty. Values that do not fit the scene, or change nothing, are faults, which are added to
    `faults`.
    """
    key, highest = f"unknown.{quoted(one.path)}", max(sweep.plane.loads)
    is_simulated, is_judged, is_heat_alone = False, False, True
    for value in _values_to_try(one):
        text = as_written(value, "1") if one.unit == "1" else one.text(value)
        try:
            other = _with_value(sweep, one.path, text)
        except InputError as error:
            faults.refuse(key, f"{error}; give values that fit, up to the outermost samples")
            return "conditions"
        scene = replace(other.scene, solved_friction=sweep.scene.solved_friction)
        is_simulated |= scene != sweep.scene
        is_judged |= other.conditions != sweep.conditions
        is_heat_alone &= mechanics(scene) == mechanics(sweep.scene)
        if step_count(scene, highest) != step_count(sweep.scene, highest):
            faults.refuse(key, "it changes the number of steps; give one value")
            return "conditions"
    if one.path == _SHARE and sweep.conditions.criterion != "share":
        is_judged = False  # no other criterion uses it
    if not (is_simulated or is_judged):
        faults.refuse(key, "no temperature or wear of this scene depends on it; leave it out")
    if not is_simulated:
        # The stored rises depend on the failing share and on corrections, drawn for each sample.
        return "conditions" if one.path in _APPLIED else "heat"
    if one.path == SPECIFIC_WEAR_RATE:
        return "wear rate"
    return "heat" if is_heat_alone else "contact"


def _with_value(sweep: Sweep, path: str, value: Any) -> Sweep:
    """Sweep with another value at `path`, but unchanged friction curves; raises if invalid."""
    kept = {curve: entry_at(sweep.written, curve) for curve in CURVES}
    written = replace_values(sweep.written, kept | {path: value})
    other = replace(sweep, written=written, variants=Variants())
    _ = other.parts
    return other


def _values_to_try(one: Unknown) -> list[float]:
    """Values [SI] to try for an input: all values of a list, else median and extreme values."""
    shares = scipy.special.ndtr(np.array([0.0, -REACH, REACH]))
    return [*one.parameters] if one.kind == "list" else one.quantile(shares).tolist()
