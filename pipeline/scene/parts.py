"""Parts of a scene, made from the tables of its file: the bodies, loading, wear, oil, corrections.

Each is None where its table is missing or faulty.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tribo
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.sweep.own_laws import Own

Loading = tribo.Ramp | tribo.MeasuredLoad
Pin = tribo.Cylinder | tribo.Ball | tribo.Crowned
_NOMINAL = 1000.0  # kg/m³: makes of a viscosity in mPa s as much in mm²/s


def own_of(path: str, table: Mapping[str, Any], faults: Faults) -> Own | None:
    """The law of one's own that the table at a path names."""
    if faults.touch(path):
        return None
    try:
        return Own.named(table["law"], table["parameters"])
    except tribo.InputError as error:
        faults.note(f"{path}.law", str(error))
        return None


def pin_of(table: Mapping[str, Any], material: tribo.Material) -> Pin:
    """The pin of a sound table."""
    match table["shape"]:
        case "cylinder":
            return tribo.Cylinder(table["radius"], table["length"], material)
        case "crowned":
            return tribo.Crowned(table["radius"], table["crown_radius"], material)
    return tribo.Ball(table["radius"], material)


def loading_of(
    table: Mapping[str, Any] | None, document: Document, faults: Faults
) -> Loading | None:
    """The ramp or the recorded load; a note says by which line a record was fitted."""
    if table is None or faults.touch("loading"):
        return None
    try:
        if "file" not in table:
            return tribo.Ramp(**table)
        folder = document.file_of("loading.file").parent
        record = tribo.read_load(folder / table["file"], table["reference_load"])
        if not table["fit"]:
            return record
        rate, onset = record.linear_fit()
    except tribo.InputError as error:
        key = "loading.file" if "file" in table else "loading"
        faults.note(key, " ".join(str(error).split()))
        return None
    faults.notes.append(f"loading.file: fitted by {rate:.4g} N/s from {round(onset, 3) + 0:g} s on")
    return record.ramp()


def wear_of(table: Mapping[str, Any] | None, faults: Faults) -> Any:
    """Archard's wear, or a law of one's own."""
    if table is None or faults.touch("wear"):
        return None
    return own_of("wear", table, faults) if "law" in table else tribo.Wear(**table)


def oil_of(table: Mapping[str, Any] | None, faults: Faults) -> tribo.Oil | None:
    """The lubricant.

    Where the dynamic viscosity is given, the equation between its two temperatures is applied to
    its value in mPa s, as ASTM D341 does it to the kinematic one in mm²/s; it needs no density
    then.
    """
    if table is None or faults.touch("oil"):
        return None
    kinematic, dynamic = table["kinematic_viscosity"], table["dynamic_viscosity"]
    coefficient = table["pressure_viscosity_coefficient"]
    pair = coefficient if isinstance(coefficient, tuple) else (coefficient, coefficient)
    try:
        return tribo.Oil(
            table["temperatures"],
            kinematic or tuple(value / _NOMINAL for value in dynamic),
            table["density"] if kinematic else _NOMINAL,
            None if coefficient is None else pair,
        )
    except tribo.InputError as error:
        faults.note("oil", str(error))
        return None


def corrections_of(
    tables: Mapping[str, Any], pin: Pin, disk: tribo.Material
) -> tribo.Corrections | None:
    """Physics beside the two half-spaces, of sound tables."""
    coefficient = tables["friction"]["coefficient"]
    rod, film = tables["pin"]["stem"], tables["disk"]["film"]
    track = tables["disk"]["track_length"]
    measured = sorted(
        (entry["velocity"], entry["coefficient"]) for entry in tables["friction"]["by_velocity"]
    )
    stem = None
    if rod and "resistance" in rod:
        stem = tribo.Stem(rod["resistance"])
    elif rod:
        conduction = pin.material.thermal_conductivity, pin.material.thermal_diffusivity
        stem = tribo.Stem.rod(rod["length"], rod["area"], *conduction)
    corrections = tribo.Corrections(
        friction=tuple((velocity, mu / coefficient) for velocity, mu in measured),
        track=tribo.Track.under(pin, disk, track) if track else None,
        stem=stem,
        film_resistance=film["thickness"] / film["thermal_conductivity"] if film else 0.0,
    )
    return corrections if corrections != tribo.Corrections() else None
