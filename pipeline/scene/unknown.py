"""Inputs that are not known exactly: the table ``[unknown]``, and samples of the whole scene.

A sample is read as if its values stood in the file: whatever follows from an entry, and whatever
an entry must fit to, follows and must fit there, too. That a distribution keeps to what is allowed
is seen at its ends, beyond which one of ten thousand samples lies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy  # its special functions take 0.2 s to load

from pipeline.scene.correlation import with_correlations
from pipeline.scene.entries import quoted
from pipeline.scene.faults import Fault
from pipeline.scene.format import FORMAT
from pipeline.scene.units import UnitError, si_unit, to_si
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.samples import (
    REACH,
    WEAR_RATE,
    Design,
    Layer,
    Samples,
    drawn_samples,
    samples_per_contact,
)
from pipeline.sweep.unknown import MOST, Kind, Unit, Unknown
from tribo import InputError, Material, Scene, Wear, inseparable

Build = Callable[[dict[str, Any], list[Fault]], Sweep | None]
"""Makes a sweep of what the format gives; notes faults."""

_FACTOR = 1.25  # of a wear rate that is known, in which samples of a contact differ all the same
_FIXED = (
    "sweep", "fidelity", "window", "measured", "tested", "unknown", "title", "extends", "without",
)  # fmt: skip
_PAIRS: dict[tuple[str, str], Kind] = {
    ("mean", "sd"): "normal",
    ("median", "factor"): "log-normal",
    ("from", "to"): "uniform",
}
_SIGNS = {"degC": "°C", "degF": "°F", "um": "µm"}
_SHARE, _OF_RATE = "temperature.failing_share", "m s2 kg-1"  # and the unit of a wear rate
_EVERYWHERE = {"name", "title", "notes"}
_SIMULATED = {each.name for each in fields(Scene)}
_THERMAL = "thermal_conductivity", "density", "specific_heat"
_DECISIVE = _SIMULATED | {"conditions"}


@dataclass(frozen=True, slots=True)
class _Entry:
    """An unknown input, and how the file writes its values: in a unit, as whole numbers or not."""

    unknown: Unknown
    unit: str | None
    is_whole: bool

    def found(self, value: float) -> float | int:
        """A value as the format gives it."""
        return round(value) if self.is_whole else float(value)

    def written(self, value: float) -> str | float | int:
        """A value as it would stand in the file."""
        if self.unit is None:
            return self.found(value)
        return f"{self.unknown.shown.of(value):.6g} {self.unit}"


def samples_of(
    entries: Mapping[str, Any],
    found: dict[str, Any],
    sweep: Sweep,
    build: Build,
    faults: list[Fault],
    notes: list[str],
) -> Samples | None:
    """Draw the samples of a scene; None if it asks for none, or something is wrong.

    Parameters
    ----------
    entries : mapping
        The scene as TOML has it.
    found : dict
        Parts of the format that describe it.
    sweep : Sweep
        The scene without samples.
    build : callable
        Makes a sweep of other entries.
    faults : list of Fault
        List to which every fault found is added.
    notes : list of str
        List to which is added what to know of a scene that is not sampled.
    """
    count, table = found["sweep"]["samples"], found["unknown"]
    if count is not None and not table:
        problem = f"{count} does not fit a scene in which all is known; give [unknown], too"
        faults.append(Fault("sweep.samples", problem))
    if not table:
        return None
    known = len(faults)
    if sweep.unequal_bulks:
        problem = (
            "two temperatures do not go with [unknown], whose probabilities take friction to scale "
            "the whole rise: give one for both bodies, or leave out [unknown] and use irg vary"
        )
        faults.append(Fault("temperature.bulk", problem))
        return None
    read = [_entry(path, value, faults) for path, value in table.items()]
    unknown = [entry for entry in read if entry is not None]
    joint = with_correlations(tuple(entry.unknown for entry in unknown), table, faults)
    unknown = [replace(entry, unknown=own) for entry, own in zip(unknown, joint, strict=True)]
    if len(unknown) > MOST:
        faults.append(Fault("unknown", f"{len(unknown)} inputs are unknown; give {MOST} at most"))
    layers = [_layer(entry, entries, found, build, sweep, faults) for entry in unknown]
    if len(faults) > known:
        return None
    if count is None:
        inputs = "1 input" if len(unknown) == 1 else f"{len(unknown)} inputs"
        notes.append(f"unknown: {inputs} not known exactly; give sweep.samples to draw them")
        return None
    design = _design(unknown, layers, found["sweep"]["sample_seed"], sweep, faults)
    return _drawn(unknown, design, found, sweep, build, faults) if design else None


def _design(
    entries: list[_Entry],
    layers: list[Layer],
    seed: int,
    sweep: Sweep,
    faults: list[Fault],
) -> Design | None:
    """Rule by which samples are drawn; None where the sweep has no range of velocities."""
    moving = [velocity for velocity in sweep.velocities if velocity > 0]
    if len(moving) < 2 or not sweep.friction_heat:
        problem = "samples need friction, and two velocities above 0, between which each has one"
        faults.append(Fault("sweep.velocities", f"{problem}; give them"))
        return None
    ends = moving[0], moving[-1]
    separable = inseparable(sweep, ends) is None
    inputs = [
        (entry.unknown, layer)
        for entry, layer in zip(entries, layers, strict=True)
        if layer != "conditions"
    ]
    known = sweep.wear.specific_wear_rate if isinstance(sweep.wear, Wear) else 0.0
    if separable and known and "wear rate" not in layers:
        rate = Unknown(WEAR_RATE, "log-normal", (known, _FACTOR), _OF_RATE)
        inputs.append((rate, "wear rate"))
    if not separable:
        inputs = [(each, "contact" if layer != "heat" else layer) for each, layer in inputs]
    unknown, kinds = tuple(each for each, _ in inputs), tuple(layer for _, layer in inputs)
    group = samples_per_contact(kinds, known > 0, separable)
    return Design(unknown, kinds, ends, seed, group)


def _drawn(
    entries: list[_Entry],
    design: Design,
    found: dict[str, Any],
    sweep: Sweep,
    build: Build,
    faults: list[Fault],
) -> Samples | None:
    """Samples of a design; None if one is not a sound scene."""
    by_path = {entry.unknown.path: entry for entry in entries}
    wrong: list[Fault] = []

    def part(values: tuple[float, ...]) -> tuple[tuple[str, Any], ...]:
        variant = found
        for each, value in zip(design.inputs, values, strict=True):
            entry = by_path.get(each.path)
            variant = _with(variant, each.path, entry.found(value) if entry else value)
        built = None if wrong else build(variant, wrong)
        return () if built is None else tuple(differing(sweep, built))

    samples = drawn_samples(
        tuple(entry.unknown for entry in entries), design, found["sweep"]["samples"], part
    )
    if wrong:
        told = f"a sample is not a sound scene: {wrong[0].key}: {wrong[0].problem}"
        faults.append(Fault("unknown", f"{told}; give narrower distributions"))
        return None
    return samples


def differing(sweep: Sweep, other: Sweep) -> Iterator[tuple[str, Any]]:
    """Fields, and their values, in which another sweep differs from one."""
    for each in fields(Sweep):
        own, new = getattr(sweep, each.name), getattr(other, each.name)
        if each.name not in _EVERYWHERE and own is not new and own != new:
            yield each.name, new


def _entry(path: str, value: Any, faults: list[Fault]) -> _Entry | None:
    """Read the distribution of one input; None if it is faulty."""
    key = f"unknown.{quoted(path)}"
    if path.partition(".")[0] in _FIXED or "." not in path:
        problem = (
            "this cannot be unknown; give an entry of what is simulated or judged, such as "
            '"wear.specific_wear_rate" or "temperature.critical"'
        )
        faults.append(Fault(key, problem))
        return None
    kind: Kind = "list"
    given: tuple[Any, ...] = value if isinstance(value, tuple) else ()
    if not given:
        pair = next(pair for pair in _PAIRS if set(pair) <= set(value))
        kind, given = _PAIRS[pair], tuple(value[name] for name in pair)
    try:
        return _distribution(path, kind, given)
    except (UnitError, InputError) as error:
        faults.append(Fault(key, str(error)))
        return None


def _distribution(path: str, kind: Kind, given: tuple[Any, ...]) -> _Entry:
    first = given[0]
    is_text = isinstance(first, str)
    if kind != "log-normal" and any(isinstance(each, str) != is_text for each in given):
        raise UnitError(f"{', '.join(map(quoted, given))}: give all with a unit, or none")
    if not is_text:
        is_whole = all(isinstance(each, int) for each in given)
        numbers = tuple(map(float, given))
        return _Entry(Unknown(path, kind, numbers), None, is_whole and kind == "list")
    _number, unit = first.strip().partition(" ")[::2]
    if not unit.strip():
        problem = f"{quoted(first)} is not a number with its unit; only numbers can be unknown"
        raise UnitError(f'{problem}: give one such as "2 mm", with a space')
    unit = unit.strip()
    values = [to_si(first, first)]
    for each in given[1:]:
        if kind == "log-normal":
            values.append(float(each))
        elif kind == "normal":
            values.append(_spread(each, first))
        else:
            values.append(to_si(each, first))
    unknown = Unknown(path, kind, tuple(values), si_unit(first), _written(first, unit))
    return _Entry(unknown, unit, is_whole=False)


def _written(text: str, unit: str) -> Unit:
    """The unit of a quantity as it is shown."""
    try:
        zero, one = (to_si(f"{n} {unit}", text) for n in (0, 1))
    except UnitError as error:
        problem = f"{quoted(text)} is on a scale of uneven steps; give it in HV, or as a pressure"
        raise UnitError(problem) from error
    return Unit(_SIGNS.get(unit, unit), one - zero, zero)


def _spread(text: str, like: str) -> float:
    """A standard deviation, which is a difference [SI]."""
    spread = to_si(text, like)
    unit = text.strip().partition(" ")[2]
    if unit and to_si(f"0 {unit}", like) != 0:
        raise UnitError(f'sd is {quoted(text)}, a temperature; give a difference, such as "8 K"')
    return spread


def _layer(
    entry: _Entry,
    entries: Mapping[str, Any],
    found: dict[str, Any],
    build: Build,
    sweep: Sweep,
    faults: list[Fault],
) -> Layer:
    """Layer of a point that an input enters; it is tried out at its ends."""
    unknown, loads = entry.unknown, max(sweep.loads)
    key = f"unknown.{quoted(unknown.path)}"
    changed: set[str] = set()
    is_heat_alone = True
    for value, where, instead in _tried(entry):
        wrong: list[Fault] = []
        FORMAT.read(_with(dict(entries), unknown.path, entry.written(value)), "", wrong)
        built = None if wrong else build(_with(found, unknown.path, entry.found(value)), wrong)
        if built is None:
            why = f"{wrong[0].key}: {wrong[0].problem}" if wrong else "the scene does not fit"
            faults.append(Fault(key, f"{where}{why}{instead}"))
            return "conditions"
        changed |= {name for name, _ in differing(sweep, built)}
        alike = {name for name, _ in differing(sweep, _with_heat_of(built, sweep))}
        is_heat_alone &= not alike & _SIMULATED
        if step_count(built, loads) != step_count(sweep, loads):
            faults.append(Fault(key, "it changes the number of steps, which must stay; give it"))
    if not changed:
        faults.append(Fault(key, "it changes nothing in this scene; leave it out"))
    elif not changed & _DECISIVE:
        problem = f"no temperature or wear depends on it, only the {_listed(changed)}; leave it out"
        faults.append(Fault(key, problem))
    if unknown.path == _SHARE:
        return "heat"  # each sample has a rise of its own share
    if not changed & _SIMULATED:
        return "conditions"
    if unknown.path == WEAR_RATE:
        return "wear rate"
    return "heat" if is_heat_alone else "contact"


def _with_heat_of(built: Sweep, sweep: Sweep) -> Sweep:
    """A sweep with the thermal constants of another."""

    def thermal(material: Material) -> dict[str, float]:
        return {name: getattr(material, name) for name in _THERMAL}

    pin = replace(built.pin.material, **thermal(sweep.pin.material))
    disk = replace(built.disk, **thermal(sweep.disk))
    return replace(built, pin=replace(built.pin, material=pin), disk=disk)


def _tried(entry: _Entry) -> Iterator[tuple[float, str, str]]:
    """Values to try an input at; of one that does not fit, where it is met and what else to do."""
    unknown = entry.unknown
    if unknown.kind == "list":
        yield from ((value, "", "") for value in unknown.parameters)
        return
    yield float(unknown.at(np.array([0.5]))[0]), "", ""  # what is wrong here is so everywhere
    ends = scipy.special.ndtr(np.array([-REACH, REACH]))
    for value in unknown.at(ends).tolist():
        where = f"reaches {entry.written(value)} in the outermost samples: "
        yield value, where, "; or a narrower distribution, or one with median and factor"


def _listed(names: set[str]) -> str:
    return " and ".join(sorted(name.replace("_", " ") for name in names))


def _with(tables: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """Tables with another value at a path; those on the way are copied, or made."""
    first, _, rest = path.partition(".")
    inner = tables.get(first)
    other = _with(inner if isinstance(inner, dict) else {}, rest, value) if rest else value
    return {**tables, first: other}
