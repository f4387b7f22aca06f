"""Scene files: TOML with units, read into a `Sweep`.

`FORMAT` is the whole format. Every fault of a file is found at once, those within a table while
it is read, those between tables afterwards.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

import tribo
from pipeline.scene.roughness import realizations_of, roughness_of
from pipeline.scene.schema import (
    Choice,
    Either,
    Flag,
    Kind,
    List,
    Number,
    Optional,
    Quantity,
    Range,
    Table,
    Tables,
    Text,
    Unit,
    Whole,
    did_you_mean,
    entry_at,
    quoted,
)
from pipeline.scene.units import display
from pipeline.sweep.model import Conditions, Measurement, Sweep

__all__ = ["FORMAT", "Conditions", "Measurement", "SceneFileError", "Sweep", "load_scene"]

_LARGEST_FILE = 10_000_000
_PATHS = ("wear.pattern", "loading.hold", "temperature.failing_share", "sweep.realizations")


class SceneFileError(tribo.TriboError):
    """A scene file that cannot be used.

    Attributes
    ----------
    path : Path
    faults : list of str
        Every fault, one line each: the key, what is wrong, what is allowed.
    """

    def __init__(self, path: Path, faults: list[str]) -> None:
        super().__init__(path, faults)
        self.path = path
        self.faults = faults

    def __str__(self) -> str:
        if len(self.faults) == 1:
            return f"{self.path}: {self.faults[0]}"
        return "\n  ".join([f"{self.path}: {len(self.faults)} faults", *self.faults])


def _kind(hint: Any) -> Kind:
    """Translate the type of an entry whose range `tribo` checks itself."""
    if get_origin(hint) is Literal:
        return Choice(get_args(hint))
    return {int: Whole(), float: Number(), bool: Flag(), str: Text()}[hint]


def _is_ball(pin: Any) -> bool:
    return isinstance(pin, dict) and pin.get("shape") == "ball"


def _has_file(table: Any) -> bool:
    return isinstance(table, dict) and "file" in table


def _is_list(value: Any) -> bool:
    return isinstance(value, list)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict)


SIZE = Quantity("a length", "2 mm")
LENGTH = Quantity("a length", "0.95 um")
LOAD = Quantity("a load", "200 N")
DURATION = Quantity("a duration", "4 s", zero=True)
VELOCITY = Quantity("a velocity", "1.25 m/s", zero=True)
TEMPERATURE = Quantity("a temperature", "25 degC")
FRICTION = Number(at_least=0)
SEED = Whole(at_least=0)
SURFACES = Whole(at_least=1, at_most=100_000)
SHAPE = Choice(("cylinder", "ball"))
PRESET = Choice(tuple(tribo.PRESETS))
FIDELITY = {name: Optional(_kind(hint)) for name, hint in get_type_hints(tribo.Fidelity).items()}

FORMAT = Table({
    "title": Optional(Text()),
    "materials": Tables(Table({
        "elastic_modulus": Quantity("a modulus", "210 GPa"),
        "poisson_ratio": Number(above=-1, at_most=0.5),
        "hardness": Optional(Quantity("a pressure", "6.6 GPa"), math.inf),
        "thermal_conductivity": Quantity("a conductivity", "45 W/(m K)"),
        "density": Quantity("a density", "7800 kg/m^3"),
        "specific_heat": Quantity("a specific heat", "470 J/(kg K)"),
    })),
    "pin": Either(
        Table({"shape": SHAPE, "radius": SIZE, "length": SIZE, "material": Text()}),
        Table({"shape": SHAPE, "radius": SIZE, "material": Text()}),
        when=_is_ball,
    ),
    "disk": Table({
        "material": Text(),
        "roughness": Optional(Either(
            Table({
                "ra": LENGTH,
                "hurst_exponent": Number(above=0, at_most=1),
                "correlation_length": Either(LENGTH, List(LENGTH, length=2), when=_is_list),
                "seed": Optional(SEED, 0),
            }),
            Table({
                "file": Text(),
                "height_unit": Optional(Unit("a unit of length", "um")),  # where the file has none
                "crop": Optional(List(Whole(at_least=0), length=2)),  # its first row and column
                "level": Optional(Flag(), False),
                "missing": Optional(Choice(("refuse", "fill")), "refuse"),
            }),
            when=_has_file,
        )),
    }),
    "window": Table({
        "pixels": List(Whole(at_least=1, at_most=100_000), length=2),
        "pixel_size": List(LENGTH, length=2),
        "periodic_y": Optional(Flag()),  # by default as the pin's shape has it
    }),
    "loading": Either(
        Table({
            "rate": Quantity("a loading rate", "150 N/s"),
            "reference_load": LOAD,
            "hold": Optional(DURATION, 0.0),
            "hold_steps": Optional(Whole(at_least=1)),
        }),
        Table({
            "file": Text(),
            "reference_load": Optional(LOAD),  # by default the record's peak
            "fit": Optional(Flag(), False),  # a straight line in place of the record itself
        }),
        when=_has_file,
    ),
    "wear": Optional(Table({
        "specific_wear_rate": Quantity("a wear rate", "1.2e-6 mm^3/(N m)", zero=True),
        "pattern": _kind(get_type_hints(tribo.Wear)["pattern"]),
    })),
    "friction": Table({
        "coefficient": FRICTION,
        "band": Optional(List(FRICTION, length=2)),
    }),
    "temperature": Table({
        "bulk": TEMPERATURE,
        "critical": TEMPERATURE,
        "failing_share": Optional(Number(at_least=0, below=1), 0.1),
    }),
    "fidelity": Optional(Table({"preset": Optional(PRESET), **FIDELITY})),
    "sweep": Table({
        "loads": Either(List(LOAD, distinct=True), Range(LOAD), when=_is_table),
        "velocities": Either(List(VELOCITY, distinct=True), Range(VELOCITY), when=_is_table),
        "realizations": Optional(Either(SURFACES, List(SEED, distinct=True), when=_is_list)),
        "fields": Optional(Flag(), False),
        "independent": Optional(Flag(), False),
    }),
    "measured": Optional(
        List(Table({"load": LOAD, "velocity": VELOCITY, "friction": Optional(FRICTION)})), ()
    ),
})  # fmt: skip


def load_scene(
    path: str | PathLike[str],
    preset: str | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Sweep:
    """Read a scene file; `FORMAT` says what it holds.

    Parameters
    ----------
    path : path-like
        Files that the scene names are relative to its folder.
    preset : str, optional
        Name of the fidelity to use in place of the file's whole table ``[fidelity]``, its preset
        and its single entries: what is asked for now goes before what was written then.
    overrides : mapping, optional
        Fields of `tribo.Fidelity`, applied last; or entries of the file by their key path, such
        as ``wear.pattern``, in place of what it says there.

    Raises
    ------
    SceneFileError
        With every fault of the file and of the arguments.
    """
    path = Path(path)
    faults: list[str] = []
    overrides = {key.removeprefix("fidelity."): value for key, value in (overrides or {}).items()}
    entries = {key: overrides.pop(key) for key in list(overrides) if "." in key}
    preset = overrides.pop("preset", preset)
    found = FORMAT.read(_changed(_toml(path), entries, faults), "", faults)
    fidelity, preset = _fidelity(found["fidelity"] or {}, preset, overrides, faults)
    notes: list[str] = []
    realizations = realizations_of(found, faults)
    roughness = roughness_of(found, path.parent, faults, notes)
    loading = _loading(found["loading"], path.parent, faults, notes)
    _check_tables(found, fidelity, roughness, faults)
    if faults or loading is None:
        raise SceneFileError(path, faults)
    try:
        sweep = _sweep(path.stem, found, loading, roughness, realizations, fidelity, preset)
    except tribo.InputError as error:
        raise SceneFileError(path, [str(error)]) from error
    return replace(sweep, notes=tuple(notes))


def _toml(path: Path) -> dict[str, Any]:
    """Read the file."""
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneFileError(path, [f"cannot be read: {reason}"]) from error
    if len(content) > _LARGEST_FILE:
        raise SceneFileError(path, [f"is larger than {_LARGEST_FILE // 10**6} MB"])
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fault = f"line {line} is not UTF-8; save the file in that encoding"
        raise SceneFileError(path, [fault]) from error
    except (ValueError, RecursionError) as error:
        reason = str(error).replace("Cannot overwrite a value", "A key is given twice")
        raise SceneFileError(path, [f"is not valid TOML: {reason}"]) from error


def _changed(
    document: dict[str, Any], entries: Mapping[str, Any], faults: list[str]
) -> dict[str, Any]:
    """The document with other entries, whose tables are made where there are none."""
    for key, value in entries.items():
        *tables, last = key.split(".")
        table: Any = document
        for name in tables:
            table = table.setdefault(name, {}) if isinstance(table, dict) else None
        if isinstance(table, dict):
            table[last] = value
        else:
            faults.append(f"overrides.{key}: {'.'.join(tables)} is no table")
    return document


def _fidelity(
    table: Mapping[str, Any],
    preset: str | None,
    overrides: Mapping[str, Any],
    faults: list[str],
) -> tuple[tribo.Fidelity, str | None]:
    """Choose the fidelity; name its preset if it equals that."""
    wanted = PRESET.read(preset, "preset", faults) if preset is not None else None
    name = wanted or table.get("preset") or "standard"
    fidelity = tribo.PRESETS[name]
    entries = {key: value for key, value in table.items() if key != "preset"}
    for key in set(overrides) - set(FIDELITY):
        faults.append(
            f"overrides.{key}: unknown key{did_you_mean(key, [*FIDELITY, *_PATHS])}; give one of "
            f"{', '.join(FIDELITY)}; or a path such as {' or '.join(_PATHS[:2])}"
        )
    known = {key: value for key, value in overrides.items() if key in FIDELITY}
    last = Table(FIDELITY).read(known, "overrides", faults)
    for where, values, counts in (
        ("fidelity", entries, preset is None),
        ("overrides", last, True),
    ):
        for key, value in values.items():
            if value is None:
                continue
            try:
                changed = replace(fidelity, **{key: value})
            except tribo.InputError as error:
                faults.append(f"{where}.{key}: {error}")
            else:
                fidelity = changed if counts else fidelity
    return fidelity, name if fidelity == tribo.PRESETS[name] else None


def _loading(
    table: Mapping[str, Any] | None, folder: Path, faults: list[str], notes: list[str]
) -> tribo.Ramp | tribo.MeasuredLoad | None:
    """Make the loading; None if it is faulty."""
    if table is None or any(
        entry is None for key, entry in table.items() if key not in ("reference_load", "hold_steps")
    ):
        return None
    try:
        if "file" in table:
            record = tribo.read_load(folder / table["file"], table["reference_load"])
            if not table["fit"]:
                return record
            rate, onset = record.linear_fit()
            notes.append(
                f"loading.file: fitted by {rate:.4g} N/s from {round(onset, 3) + 0:g} s on"
            )
            return record.ramp()
        return tribo.Ramp(**table) if table["reference_load"] else None
    except tribo.InputError as error:
        key = "loading.file" if "file" in table else "loading"
        faults.append(f"{key}: {' '.join(str(error).split())}")
        return None


def _check_tables(
    found: dict[str, Any],
    fidelity: tribo.Fidelity,
    roughness: tribo.SelfAffineRoughness | tribo.MeasuredRoughness | None,
    faults: list[str],
) -> None:
    """Note what does not fit together, as far as the entries in question are sound."""
    materials = found["materials"]
    for body in ("pin", "disk"):
        name = entry_at(found, f"{body}.material")
        if name and materials and name not in materials:
            allowed = " or ".join(map(quoted, materials))
            hint = did_you_mean(name, materials)
            faults.append(
                f"{body}.material: {quoted(name)} names no table of [materials]{hint}; "
                f"give {allowed}"
            )

    pixels, block = entry_at(found, "window.pixels"), fidelity.pixels_per_element
    if pixels and any(n % block for n in pixels):
        faults.append(
            f"window.pixels: {quoted(list(pixels))} cannot be averaged {block} × {block}; give "
            f"multiples of {block}, or another fidelity.pixels_per_element"
        )
    if pixels == (1, 1) and isinstance(roughness, tribo.SelfAffineRoughness):
        faults.append("window.pixels: [1, 1] cannot be rough; give more, or no disk.roughness")
    if pixels and isinstance(roughness, tribo.MeasuredRoughness):
        shape = roughness.array.shape
        if shape != pixels:
            faults.append(
                f"disk.roughness.file: {shape[0]} rows of {shape[1]} heights; give as many as "
                f"window.pixels, {quoted(list(pixels))}"
            )

    length, sides = entry_at(found, "pin.length"), entry_at(found, "window.pixel_size")
    if length and pixels and sides and length < pixels[1] * sides[1] * (1 - 1e-9):
        faults.append(
            f"pin.length: {display(length, 'mm')} is shorter than the window, which is "
            f"{display(pixels[1] * sides[1], 'mm')} along y; give at least that"
        )

    ball, periodic_y = entry_at(found, "pin.shape") == "ball", entry_at(found, "window.periodic_y")
    if ball and periodic_y:
        faults.append("window.periodic_y: true does not fit a ball; give false, or leave it out")
    if entry_at(found, "wear.pattern") == "swept" and (ball or periodic_y is False):
        faults.append(
            'wear.pattern: "swept" averages along y, which needs a window that is periodic along '
            'y, under a cylinder; give "local"'
        )

    bulk, critical = entry_at(found, "temperature.bulk"), entry_at(found, "temperature.critical")
    if bulk and critical and critical <= bulk:
        faults.append(
            f"temperature.critical: {display(critical, '°C')} is not above temperature.bulk, "
            f'{display(bulk, "°C")}; give a higher one, such as "145 degC"'
        )
    band = entry_at(found, "friction.band")
    if band and band[0] > band[1]:
        faults.append(f"friction.band: {quoted(list(band))} falls; give the lower one first")


def _sweep(
    name: str,
    found: dict[str, Any],
    loading: tribo.Ramp | tribo.MeasuredLoad,
    roughness: tribo.SelfAffineRoughness | tribo.MeasuredRoughness | None,
    realizations: tuple[int, ...],
    fidelity: tribo.Fidelity,
    preset: str | None,
) -> Sweep:
    """Build what the entries say, all of them sound."""
    materials = {key: tribo.Material(**table) for key, table in found["materials"].items()}
    pin, disk, window, sweep = found["pin"], found["disk"], found["window"], found["sweep"]
    friction, temperature = found["friction"], found["temperature"]
    cylinder, periodic_y = pin["shape"] == "cylinder", window["periodic_y"]
    material = materials[pin["material"]]
    return Sweep(
        pin=tribo.Cylinder(pin["radius"], pin["length"], material)
        if cylinder
        else tribo.Ball(pin["radius"], material),
        disk=materials[disk["material"]],
        pixels=tribo.Grid(
            window["pixels"],
            window["pixel_size"],
            periodic=(False, cylinder if periodic_y is None else periodic_y),
        ),
        loading=loading,
        roughness=roughness,
        wear=tribo.Wear(**found["wear"]) if found["wear"] else None,
        friction_heat=max([friction["coefficient"], *(friction["band"] or [])]) > 0,
        fidelity=fidelity,
        name=name,
        title=found["title"] or name,
        loads=tuple(sorted(set(sweep["loads"]))),
        velocities=tuple(sorted(set(sweep["velocities"]))),
        conditions=Conditions(
            friction["coefficient"],
            temperature["bulk"],
            temperature["critical"],
            temperature["failing_share"],
        ),
        realizations=realizations,
        friction_band=friction["band"],
        measured=tuple(
            Measurement(entry["load"], entry["velocity"], entry["friction"])
            for entry in found["measured"]
        ),
        store_fields=sweep["fields"],
        independent=sweep["independent"],
        preset=preset,
    )
