"""Scene files: TOML with units, read into a `Sweep`.

`pipeline.scene.format.FORMAT` is the whole format. Every fault of a file is found at once: those
within a table while it is read, those between tables afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import tribo
from pipeline.scene.consistency import check_tables
from pipeline.scene.document import Document, read_document, with_entries
from pipeline.scene.faults import Fault, SceneFileError
from pipeline.scene.format import FIDELITY, FORMAT, PRESET
from pipeline.scene.roughness import realizations_of, roughness_of
from pipeline.scene.schema import Table, did_you_mean
from pipeline.sweep.criterion import Conditions
from pipeline.sweep.model import Measurement, Sweep

_PATHS = ("wear.pattern", "loading.hold", "temperature.failing_share", "sweep.realizations")

Loading = tribo.Ramp | tribo.MeasuredLoad


def load_scene(
    path: str | PathLike[str],
    preset: str | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Sweep:
    """Read a scene file, and the scenes that it extends.

    Parameters
    ----------
    path : path-like
        Scene file. Files named in it are relative to the folder of the file that names them.
    preset : str, optional
        Name of the fidelity to use in place of the scene's whole table ``[fidelity]``, its preset
        and its single entries.
    overrides : mapping, optional
        Fields of `tribo.Fidelity`, applied last; or entries of the scene by their key path, such
        as ``wear.pattern``, in place of what the file says there.

    Raises
    ------
    SceneFileError
        If there is any fault in the file or the arguments; it carries all of them.
    """
    path = Path(path)
    faults: list[Fault] = []
    notes: list[str] = []
    overrides = {key.removeprefix("fidelity."): value for key, value in (overrides or {}).items()}
    entries = {key: overrides.pop(key) for key in list(overrides) if "." in key}
    document = with_entries(read_document(path, faults), entries, faults)
    found = FORMAT.read(document.entries(), "", faults)
    preset = overrides.pop("preset", preset)
    fidelity, preset = _fidelity(found["fidelity"] or {}, preset, overrides, faults)
    realizations = realizations_of(found, faults)
    roughness = roughness_of(found, document, faults, notes)
    loading = _loading(found["loading"], document, faults, notes)
    check_tables(found, fidelity, roughness, faults)
    if faults or loading is None:
        raise SceneFileError(path, [document.line(fault) for fault in faults])
    try:
        return Sweep(
            **_entries(path.stem, found),
            loading=loading,
            roughness=roughness,
            realizations=realizations,
            fidelity=fidelity,
            preset=preset,
            notes=tuple(notes),
        )
    except tribo.InputError as error:
        raise SceneFileError(path, [str(error)]) from error


def _fidelity(
    table: Mapping[str, Any],
    preset: str | None,
    overrides: Mapping[str, Any],
    faults: list[Fault],
) -> tuple[tribo.Fidelity, str | None]:
    """Choose the fidelity; name its preset if it equals that."""
    wanted = PRESET.read(preset, "preset", faults) if preset is not None else None
    name = wanted or table.get("preset") or "standard"
    fidelity = tribo.PRESETS[name]
    entries = {key: value for key, value in table.items() if key != "preset"}
    for key in set(overrides) - set(FIDELITY):
        problem = (
            f"unknown key{did_you_mean(key, [*FIDELITY, *_PATHS])}; give one of "
            f"{', '.join(FIDELITY)}; or a path such as {' or '.join(_PATHS[:2])}"
        )
        faults.append(Fault(f"overrides.{key}", problem))
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
                faults.append(Fault(f"{where}.{key}", str(error)))
            else:
                fidelity = changed if counts else fidelity
    return fidelity, name if fidelity == tribo.PRESETS[name] else None


def _loading(
    table: Mapping[str, Any] | None, document: Document, faults: list[Fault], notes: list[str]
) -> Loading | None:
    """Make the loading; None if it is faulty."""
    if table is None or any(
        entry is None for key, entry in table.items() if key not in ("reference_load", "hold_steps")
    ):
        return None
    try:
        if "file" not in table:
            return tribo.Ramp(**table) if table["reference_load"] else None
        folder = document.file_of("loading.file").parent
        record = tribo.read_load(folder / table["file"], table["reference_load"])
        if not table["fit"]:
            return record
        rate, onset = record.linear_fit()
    except tribo.InputError as error:
        key = "loading.file" if "file" in table else "loading"
        faults.append(Fault(key, " ".join(str(error).split())))
        return None
    notes.append(f"loading.file: fitted by {rate:.4g} N/s from {round(onset, 3) + 0:g} s on")
    return record.ramp()


def _entries(name: str, found: dict[str, Any]) -> dict[str, Any]:
    """Fields of the sweep that follow from sound entries alone."""
    materials = {key: tribo.Material(**table) for key, table in found["materials"].items()}
    pin, window, sweep = found["pin"], found["window"], found["sweep"]
    friction, temperature = found["friction"], found["temperature"]
    cylinder, periodic_y = pin["shape"] == "cylinder", window["periodic_y"]
    material = materials[pin["material"]]
    return {
        "pin": tribo.Cylinder(pin["radius"], pin["length"], material)
        if cylinder
        else tribo.Ball(pin["radius"], material),
        "disk": materials[found["disk"]["material"]],
        "pixels": tribo.Grid(
            window["pixels"],
            window["pixel_size"],
            periodic=(False, cylinder if periodic_y is None else periodic_y),
        ),
        "wear": tribo.Wear(**found["wear"]) if found["wear"] else None,
        "friction_heat": max([friction["coefficient"], *(friction["band"] or [])]) > 0,
        "name": name,
        "title": found["title"] or name,
        "loads": tuple(sorted(set(sweep["loads"]))),
        "velocities": tuple(sorted(set(sweep["velocities"]))),
        "conditions": Conditions(
            friction["coefficient"],
            temperature["bulk"],
            temperature["critical"],
            temperature["failing_share"],
        ),
        "friction_band": friction["band"],
        "measured": tuple(
            Measurement(entry["load"], entry["velocity"], entry["friction"])
            for entry in found["measured"]
        ),
        "store_fields": sweep["fields"],
        "independent": sweep["independent"],
    }
