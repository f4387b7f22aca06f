"""Parts of a scene, made from its tables; each is None where its table is missing or faulty."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import tribo
from pipeline import extras
from pipeline.paths import user_path
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults, entry_at, quoted
from pipeline.scene.names import UNITS
from pipeline.scene.sheet import read_sheet
from tribo.loading.record import fault as record_fault

Loading = tribo.Ramp | tribo.MeasuredLoad
_Ends = tuple[float, float]
Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness | tribo.Surface
DISC = "diameter", "width", "bore", "rim_loss", "face_loss", "shaft_loss"
"""Entries of a body that is a disc."""
_RECORD = "time", "load"
_OF_INDEX = 313.15, 373.15  # K, by which ASTM D2270 defines an index
_NOMINAL = 1000.0  # kg/m³: makes of a viscosity in mPa s as much in mm²/s


def loading_of(
    table: Mapping[str, Any] | None, document: Document, faults: Faults, stops: tuple[float, ...]
) -> Loading | None:
    """The ramp or the recorded load; a note says by which line a record was fitted.

    Steps of a hold end at the stops that are shorter [s].
    """
    if table is None or faults.touch("loading"):
        return None
    with faults.at("loading.file" if "file" in table else "loading"):
        if "file" not in table:
            return tribo.Ramp(**table, stops=tuple(s for s in stops if s < table["hold"]))
        folder = document.file_of("loading.file").parent
        record = _read_record(folder / user_path(table["file"]), table["reference_load"], faults)
        if not table["fit"]:
            return record
        rate, onset = record.linear_fit()
        line = f"{rate:.4g} N/s from {round(onset, 3) + 0:g} s on"
        faults.note("loading.file", f"fitted by {line}")
        return record.ramp()
    return None


def _read_record(path: Path, reference_load: float | None, faults: Faults) -> tribo.MeasuredLoad:
    """The load over time of a file with columns of both."""
    sheet = read_sheet(path, {name: UNITS[name] for name in _RECORD}, _RECORD)
    times, loads = (
        sheet.numbers(name) if name in sheet.places else np.zeros(0) for name in _RECORD
    )
    if not sheet.faults and (reason := record_fault(times, loads)):
        sheet.faults.append(f"row {sheet.rows[reason[0]].number}: {reason[1]}")
    sheet.refuse_faults("time [s],load [N]")
    if sheet.counted:
        faults.note("loading.file", sheet.counted)
    return tribo.MeasuredLoad(times, loads, reference_load)


def wear_of(table: Mapping[str, Any] | None, faults: Faults) -> Any:
    """Archard's wear, or a law that ships."""
    if table is None or faults.touch("wear"):
        return None
    if "law" not in table:
        return tribo.Wear(table["specific_wear_rate"], table["pattern"])
    with faults.at("wear.law"):
        law: Any = tribo.LAWS[table["law"]]
        return law(**{name: value for name, value in table.items() if name != "law"})


def oil_of(table: Mapping[str, Any] | None, faults: Faults) -> tribo.Oil | None:
    """The lubricant; the equation of ASTM D341 is applied to a dynamic viscosity in mPa s, too."""
    if table is None or faults.touch("oil"):
        return None
    coefficient = table["pressure_viscosity_coefficient"]
    pair = coefficient if isinstance(coefficient, tuple) else (coefficient, coefficient)
    with faults.at("oil"):
        temperatures, viscosities = _viscosity_line(table, faults)
        return tribo.Oil(
            temperatures,
            viscosities,
            table["density"] if table["kinematic_viscosity"] else _NOMINAL,
            None if coefficient is None else pair,
        )
    return None


def _viscosity_line(table: Mapping[str, Any], faults: Faults) -> tuple[_Ends, _Ends]:
    """Two temperatures [K] and the kinematic viscosities there [m²/s]; raises an `InputError`."""
    kinematic, dynamic = table["kinematic_viscosity"], table["dynamic_viscosity"]
    temperatures, index = table["temperatures"], table["viscosity_index"]
    if (kinematic is None) == (dynamic is None):
        raise tribo.InputError(
            f"{'no' if kinematic is None else 'both a kinematic and a dynamic'} viscosity; give "
            "kinematic_viscosity with a density, or dynamic_viscosity"
        )
    if kinematic and table["density"] is None:
        raise tribo.InputError("density is missing; a kinematic viscosity needs one")
    values = kinematic or tuple(value / _NOMINAL for value in dynamic)
    values = values if isinstance(values, tuple) else (values,)
    if index is not None and (dynamic or len(values) > 1 or temperatures != _OF_INDEX):
        raise tribo.InputError(
            f"viscosity_index is {index:g}; it belongs to one kinematic viscosity, that at 40 °C: "
            'kinematic_viscosity = "220 mm^2/s", without temperatures'
        )
    if index is not None:
        return _OF_INDEX, (values[0], tribo.material.warm_viscosity(values[0], index))
    if len(values) != len(temperatures) or len(values) < 2:
        raise tribo.InputError(
            f"viscosities: {len(values)}, temperatures: {len(temperatures)}; give one for each of "
            "two temperatures or more, or that at 40 °C and viscosity_index"
        )
    ends, beside = tribo.material.viscosity_line(temperatures, values)
    if len(values) > 2:
        faults.note("oil", f"the line of ASTM D341 is up to {beside:.1%} beside the viscosities")
    return (temperatures[0], temperatures[-1]), ends


def corrections_of(
    tables: Mapping[str, Any], pin: tribo.Pin, disk: tribo.Material
) -> tribo.Corrections | None:
    """Physics beside the two half-spaces, from sound tables."""
    coefficient = tables["friction"]["coefficient"]
    rod, film = tables["pin"]["stem"], tables["disk"]["film"]
    curves: dict[str, Any] = {
        f"by_{name}": tuple(sorted((row[name], row["coefficient"] / coefficient) for row in rows))
        for name in ("velocity", "temperature")
        if (rows := tables["friction"][f"by_{name}"])
    }
    stem = None
    if rod and "resistance" in rod:
        stem = tribo.Stem(rod["resistance"])
    elif rod:
        conduction = pin.material.thermal_conductivity, pin.material.thermal_diffusivity
        stem = tribo.Stem.rod(rod["length"], rod["area"], *conduction)
    corrections = tribo.Corrections(
        friction=tribo.Friction(**curves),
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
    if body["diameter"]:
        sizes = {name: body[name] for name in DISC if body[name] is not None}
        return tribo.Track.under(pin, material, tribo.Disc(**sizes))
    length = track_of(body)
    return tribo.Track.under(pin, material, length) if length else None


def _bulk_of(body: Mapping[str, Any], material: tribo.Material) -> tribo.Bulk | None:
    """The heat capacity and the loss of a body."""
    capacity, loss = body["capacity"], body["loss"]
    if capacity is None and loss is None:
        return None
    if isinstance(capacity, Mapping):
        volume = math.pi / 4 * capacity["diameter"] ** 2 * capacity["thickness"]
        capacity = volume * material.density * material.specific_heat
    return tribo.Bulk(capacity or 0.0, loss or 0.0)


def realizations_of(tables: dict[str, Any], faults: Faults) -> tuple[int, ...]:
    """Seeds of the random surfaces; the scene takes the first."""
    wanted = entry_at(tables, "sweep.realizations")
    if wanted is None or tables["disk"] is None:
        return ()
    rough = entry_at(tables, "disk.roughness")
    if rough is None or "file" in rough:
        if not faults.touch("disk.roughness"):
            asked = wanted if isinstance(wanted, int) else list(wanted)
            faults.refuse(
                "sweep.realizations",
                f"{quoted(asked)} needs a [disk.roughness] that is made from a seed; give one, or "
                "leave this out",
            )
        return ()
    if isinstance(wanted, int):
        first = rough["seed"] or 0
        return tuple(range(first, first + wanted))
    seeds = tuple(sorted(wanted))
    rough["seed"] = seeds[0]
    return seeds


def roughness_of(tables: dict[str, Any], document: Document, faults: Faults) -> Roughness | None:
    """The disk's roughness; None if there is none, or a faulty one."""
    table = entry_at(tables, "disk.roughness")
    if table is None or faults.touch("disk.roughness"):
        return None
    if "file" in table:
        folder = document.file_of("disk.roughness.file").parent
        with faults.at("disk.roughness.file"):
            scans = extras.module("laboratory", "surfaces")
            heights = scans.window_heights(
                table, tables["window"] or {}, folder / user_path(table["file"]), faults
            )
            return None if heights is None else tribo.MeasuredRoughness(heights)
        return None
    length = table["correlation_length"]
    pair = length if isinstance(length, tuple) else (length, length)
    return tribo.SelfAffineRoughness(**{**table, "correlation_length": pair})
