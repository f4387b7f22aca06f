"""Distance from severe wear along a mesh, by simulating the places that may be the worst.

This module is the only one of the gears that uses sweeps and their margins.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

import pipeline
from pipeline.analysis.margin import NOT_DECIDED, clipped
from pipeline.analysis.margin_frame import judged, margin_frame
from pipeline.analysis.tables import frame_of
from pipeline.gears.contact import Mesh
from pipeline.gears.doubts import doubts
from pipeline.gears.scene import scene_toml
from pipeline.sweep.physics import caveat_on_turns
from pipeline.sweep.remarks import join_notes
from pipeline.sweep.stages import Report, silent

_WORSE = ("mild", NOT_DECIDED, "severe")
_DUTY = "torque [N m]", "speed [rpm]", "bulk temperature [°C]", "integral temperature [°C]"
_MARGIN = (
    "position [mm]", "load [N]", "velocity [m/s]", "verdict", "probability",
    "decisive temperature [°C]", "temperature error [K]", "distance [K]", "sentence", "notes",
)  # fmt: skip
_TOO_HOT = "the bulk temperature is above the critical temperature: not simulated"


def judge(
    meshes: Sequence[Mesh],
    preset: str | None = None,
    workers: int | None = None,
    progress: Report = silent,
) -> pd.DataFrame:
    """Simulate each mesh at the places that may be the worst, and return its worst verdict.

    A mesh whose bulk temperature reaches the critical temperature is severe, and not simulated.

    Parameters
    ----------
    meshes : sequence of Mesh
        Meshes of one pair with a critical temperature, at one or several duties.
    preset : str, optional
        Preset of the numerical choices; ``"standard"`` by default.
    workers : int, optional
        Number of processes; one for each core by default.
    progress : callable, optional
        Called with the progress of the simulations, as in `pipeline.run_sweep`.

    Returns
    -------
    DataFrame
        A row for each mesh: its duty, and the columns of `pipeline.margin` at its worst place.

    Raises
    ------
    TriboError
        If a place cannot be simulated.
    """
    warm = [one for one in meshes if not _is_too_hot(one)]
    found = iter(_worst_margins(warm, preset, workers, progress) if warm else ())
    rows = [_severe_margin(one) if _is_too_hot(one) else next(found) for one in meshes]
    duties = (
        (one.duty.torque, one.duty.turns, one.duty.bulk, one.integral and one.integral.integral)
        for one in meshes
    )
    margins = pd.DataFrame(rows, columns=pd.Index(_MARGIN))
    return pd.concat([frame_of(_DUTY, duties), margins], axis="columns")


def _worst_margins(meshes: Sequence[Mesh], *choices: Any) -> list[Mapping[str, Any]]:
    """Columns of `pipeline.margin` by name, at the worst place of each mesh.

    `choices` are preset, workers and progress, as for `judge`.
    """
    preset, workers, progress = choices
    chosen = [decisive_places(one) for one in meshes]
    numbers = [k for k, one in enumerate(chosen) for _ in one.places]
    with tempfile.TemporaryDirectory() as folder:
        file, store = Path(folder) / "mesh.toml", Path(folder) / "mesh.zarr"
        file.write_text(scene_toml(chosen), encoding="utf-8")
        sweep = pipeline.load_scene(file, preset)
        outcome = pipeline.run_sweep(sweep, store, workers, progress=progress)
        if outcome.failed:
            raise pipeline.ExecutionError(f"a place of mesh failed: {outcome.failed[0]}")
        data = pipeline.results(store)
        table = margin_frame(data, found := [*judged(data, None)])
    margins = [one.known() for one in found]
    table["sentence"] = [one.sentence for one in margins]
    # Left out below: a gear's bulk temperature already includes the heat of earlier revolutions.
    turns = caveat_on_turns(sweep, "")
    notes = ([*one.caveats, f"the model's own error: {one.model_error}"] for one in margins)
    table["notes"] = [
        _notes(meshes[k], *(said for said in own if said != turns))
        for k, own in zip(numbers, notes, strict=True)
    ]
    return [worst_row(part).to_dict() for _, part in table.groupby(numbers)]


def worst_row(table: pd.DataFrame) -> pd.Series[Any]:
    """Row with the worst verdict in a `table` of `judge`: severe, else not decided, else mild.

    Of rows with equal verdicts, it is the one with the highest probability of severe wear. If these
    are equal too, it is the hottest.
    """
    temperatures = table["decisive temperature [°C]"].astype(float).fillna(math.inf)
    keys = zip(map(_WORSE.index, table["verdict"]), table["probability"], temperatures, strict=True)
    return table.iloc[-max((key, -k) for k, key in enumerate(keys))[1]]


def decisive_places(one: Mesh) -> Mesh:
    """Copy of a mesh with only the places that may be the worst: A to E, and the hottest.

    Places without sliding are left out. The hottest places are local maxima of the temperature of
    smooth flanks. Rough flanks are hotter by a factor that changes slowly along the path.
    """
    heat = [at.temperature for at in one.places]
    kept = (
        at
        for k, at in enumerate(one.places)
        if at.sliding and (at.letter or at.temperature == max(heat[max(k - 1, 0) : k + 2]))
    )
    return replace(one, places=tuple(kept))


def _is_too_hot(one: Mesh) -> bool:
    """True if the bulk temperature alone reaches the critical temperature."""
    return one.pair.critical is not None and one.duty.bulk >= one.pair.critical


def _severe_margin(one: Mesh) -> dict[str, Any]:
    """Columns of `pipeline.margin` for a mesh whose bulk temperature reaches the critical one."""
    severe = {"verdict": "severe", "probability": clipped(1.0), "sentence": f"Severe: {_TOO_HOT}"}
    return severe | {"notes": _notes(one, _TOO_HOT)}


def _notes(one: Mesh, *others: str) -> str | None:
    return join_notes([*map(str, doubts(one)), *one.pair.caveats, *others])
