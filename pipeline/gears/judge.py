"""Margins of places of mesh: the rough, worn contact of those that may decide, simulated.

All that gears ask of the answers of the pipeline is asked here.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import pandas as pd

import pipeline
from pipeline.analysis.margin import NOT_DECIDED, told
from pipeline.analysis.margin_frame import Judged, judged, margin_frame
from pipeline.analysis.tables import frame_of
from pipeline.gears.contact import Mesh
from pipeline.gears.doubts import doubts
from pipeline.gears.scene import scene_toml
from pipeline.sweep.caveats import joined
from pipeline.sweep.stages import Report, silent

_WORSE = ("mild", NOT_DECIDED, "severe")
_DUTY = "torque [N m]", "speed [rpm]", "bulk temperature [°C]", "integral temperature [°C]"
_MARGIN = (
    "position [mm]", "load [N]", "velocity [m/s]", "verdict", "probability",
    "decisive temperature [°C]", "temperature error [K]", "distance [K]", "sentence", "notes",
)  # fmt: skip
_TOO_HOT = "the teeth alone are above the critical temperature: not simulated"


def judge(
    meshes: Sequence[Mesh],
    preset: str | None = None,
    workers: int | None = None,
    progress: Report = silent,
) -> pd.DataFrame:
    """Simulate the places that may decide, and take the margin of the worst of each mesh.

    A mesh whose teeth alone are above the critical temperature is severe, and is not simulated.

    Parameters
    ----------
    meshes : sequence of Mesh
        Of one pair with a critical temperature, at one duty or several.
    preset : str, optional
        Preset of the numerical choices; ``"standard"`` by default.
    workers : int, optional
        Number of processes; one for each core by default.
    progress : callable, optional
        See `pipeline.run_sweep`.

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
    found = _worst_margins(warm, preset, workers, progress) if warm else iter(())
    rows = [_severe(one) if _is_too_hot(one) else next(found) for one in meshes]
    duties = (
        (one.duty.torque, one.duty.turns, one.duty.bulk, one.integral and one.integral.integral)
        for one in meshes
    )
    margins = pd.DataFrame(rows, columns=pd.Index(_MARGIN))
    return pd.concat([frame_of(_DUTY, duties), margins], axis="columns")


def _worst_margins(meshes: Sequence[Mesh], *choices: Any) -> Iterator[dict[str, Any]]:
    """Margin of the worst place of each mesh, by its columns."""
    preset, workers, progress = choices
    chosen = [decisive_places(one) for one in meshes]
    with tempfile.TemporaryDirectory() as folder:
        file, store = Path(folder) / "mesh.toml", Path(folder) / "mesh.zarr"
        file.write_text(scene_toml(chosen), encoding="utf-8")
        sweep = pipeline.load_scene(file, preset)
        outcome = pipeline.run_sweep(sweep, store, workers, progress=progress)
        if outcome.failed:
            raise pipeline.ExecutionError(f"a place of mesh failed: {outcome.failed[0]}")
        ds = pipeline.open_sweep(store)
        found = judged(ds, None)
        worst = [max(islice(found, len(one.places)), key=_rank) for one in chosen]
        table = margin_frame(ds, worst)
    margins = [one.known() for one in worst]
    table["sentence"] = [one.sentence for one in margins]
    table["notes"] = [
        _notes(mesh, *one.caveats, f"the model's own error: {one.model_error}")
        for mesh, one in zip(meshes, margins, strict=True)
    ]
    yield from table.to_dict("records")


def decisive_places(one: Mesh) -> Mesh:
    """The mesh at the places that may decide: letters with sliding, and the hottest of its range.

    Rough flanks are hotter than smooth ones, by a factor that changes slowly along the path.
    """
    heat = [at.temperature for at in one.places]
    kept = (
        at
        for k, at in enumerate(one.places)
        if at.sliding and (at.letter or at.temperature == max(heat[max(k - 1, 0) : k + 2]))
    )
    return replace(one, places=tuple(kept))


def _rank(place: Judged) -> tuple[int, float, float]:
    here = place.known()
    return rank(here.verdict, told(here.probability), here.decisive_temperature)


def rank(verdict: str, probability: float, temperature: float) -> tuple[int, float, float]:
    """Key by which a worse place or duty is the larger one."""
    return _WORSE.index(verdict), probability, temperature


def _is_too_hot(one: Mesh) -> bool:
    """True if the teeth alone are as hot as the critical temperature."""
    return one.pair.critical is not None and one.duty.bulk >= one.pair.critical


def _severe(one: Mesh) -> dict[str, Any]:
    """A mesh whose teeth alone are too hot."""
    notes = _notes(one, _TOO_HOT)
    severe = {"verdict": "severe", "probability": told(1.0), "sentence": f"Severe: {_TOO_HOT}"}
    return severe | {"notes": notes}


def _notes(one: Mesh, *others: str) -> str | None:
    return joined([*map(str, doubts(one)), *one.pair.caveats, *others])
