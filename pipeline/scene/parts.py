"""Parts of a scene, made from the tables of its file: the bodies, loading, wear, oil, corrections.

Each is None where its table is missing or faulty.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import tribo
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.sweep.own_laws import CRITERION, WEAR, Laws, Own, OwnLawError
from tribo.simulation.pins import sizes_of

Loading = tribo.Ramp | tribo.MeasuredLoad
_NOMINAL = 1000.0  # kg/m³: makes of a viscosity in mPa s as much in mm²/s


def own_of(
    key: str,
    kind: str,
    reference: str,
    laws: Laws,
    faults: Faults,
    parameters: Mapping[str, Any] | None = None,
) -> Own | None:
    """The code that the entry of a key names; `OwnLawError` if it may not run."""
    try:
        return laws.named(kind, reference, parameters)
    except OwnLawError:
        raise  # alone, since nothing else of such a scene is worth a look
    except tribo.InputError as error:
        faults.note(key, str(error))
        return None


def pin_of(table: Mapping[str, Any], material: tribo.Material) -> tribo.Pin:
    """The pin of a sound table."""
    kind: Any = tribo.PINS[table["shape"]]
    pin: tribo.Pin = kind(
        **{name: table[name] for name in sizes_of(table["shape"])}, material=material
    )
    return pin


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


def wear_of(table: Mapping[str, Any] | None, laws: Laws, faults: Faults) -> Any:
    """Archard's wear, or a user's own law."""
    if table is None or faults.touch("wear"):
        return None
    if "law" in table:
        return own_of("wear.law", WEAR, table["law"], laws, faults, table["parameters"])
    return tribo.Wear(**table)


def criterion_of(table: Mapping[str, Any] | None, laws: Laws, faults: Faults) -> Own | None:
    """A user's own criterion; None where it is one of ours."""
    name = (table or {}).get("criterion")
    if name is None or ":" not in name:
        return None
    return own_of("temperature.criterion", CRITERION, name, laws, faults)


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
    tables: Mapping[str, Any], pin: tribo.Pin, disk: tribo.Material
) -> tribo.Corrections | None:
    """Physics beside the two half-spaces, from sound tables."""
    coefficient = tables["friction"]["coefficient"]
    rod, film = tables["pin"]["stem"], tables["disk"]["film"]
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
        track=_ring_of(tables["disk"], pin, disk),
        pin_track=_ring_of(tables["pin"], pin, pin.material),
        stem=stem,
        film_resistance=film["thickness"] / film["thermal_conductivity"] if film else 0.0,
        pin_bulk=_bulk_of(tables["pin"], pin.material),
        disk_bulk=_bulk_of(tables["disk"], disk),
        motion=motion_of(tables)
        if any(track_of(tables[body]) for body in ("pin", "disk"))
        else None,
    )
    return corrections if corrections != tribo.Corrections() else None


def motion_of(tables: Mapping[str, Any]) -> tribo.Motion | None:
    """The motion of both bodies; the pin's wear spreads over the track around it."""
    motion = tables["motion"]
    if not motion:
        return None
    return tribo.Motion(
        **motion | {"track_length": motion["track_length"] or track_of(tables["pin"])}
    )


def track_of(body: Mapping[str, Any]) -> float | None:
    """Length of the track around a body [m]; None if its table gives none."""
    length: float | None = body["track_length"]
    return math.pi * body["diameter"] if body["diameter"] else length


def _ring_of(
    body: Mapping[str, Any], pin: tribo.Pin, material: tribo.Material
) -> tribo.Track | None:
    """The track around a body of a material; None if its table gives none."""
    length = track_of(body)
    return tribo.Track.under(pin, material, length, body["width"]) if length else None


def _bulk_of(body: Mapping[str, Any], material: tribo.Material) -> tribo.Bulk | None:
    """The heat capacity and the loss of a body."""
    capacity, loss = body["capacity"], body["loss"]
    if capacity is None and loss is None:
        return None
    if isinstance(capacity, Mapping):
        volume = math.pi / 4 * capacity["diameter"] ** 2 * capacity["thickness"]
        capacity = volume * material.density * material.specific_heat
    return tribo.Bulk(capacity or 0.0, loss or 0.0)
