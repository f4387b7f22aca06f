"""A sweep as a store keeps it: plain data in SI, of which cases and tests are changes of the base.

The text of the scene is stored for people, too, but never read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import tribo
from pipeline.sweep.case import Case, Conditions, SpecimenTest, Uncertainty, Variant
from pipeline.sweep.case_table import CaseTable, Column
from pipeline.sweep.codec import CodecError, apply_difference, decode, encode, encode_difference
from pipeline.sweep.notes import FromLibrary, SceneWarning
from pipeline.sweep.stored_steps import StoredSteps
from pipeline.sweep.sweep import Sweep
from pipeline.sweep.user_laws import UserLaw, UserSurface
from tribo import InputError
from tribo.simulation.lubrication import SurfaceSummary
from tribo.surface import UnknownHeights
from tribo.types import Array
from tribo.wear import WEAR_LAWS

_WITH_CASES = {"tests", "variants"}
"""Fields of a sweep whose items each have a case."""


class MissingError(InputError):
    """The content of a file that a scene names is needed, but was not stored with the scene."""


@dataclass(frozen=True)
class MissingSurface(UnknownHeights):
    """A measured surface whose heights are not known, since they were left out of a dataset."""

    digest: str
    shape: tuple[int, ...]

    def heights(self, pixels: Any) -> Any:
        """Raise a `MissingError`: the heights are not known."""
        raise MissingError(f"{self}; open the store of the sweep")

    def __str__(self) -> str:
        return "the heights of the measured surface are missing"


_CLASSES: dict[str, type] = {
    cls.__name__: cls
    for cls in (
        Sweep, Case, SpecimenTest, Variant, Uncertainty, CaseTable, Column, StoredSteps,
        SceneWarning, FromLibrary, MissingSurface, Conditions, tribo.Corrections, tribo.Track,
        tribo.Disc,
        tribo.Scene, tribo.Material, tribo.Grid, tribo.Ramp, tribo.Stages, tribo.MeasuredLoad,
        tribo.SelfAffineRoughness, tribo.MeasuredRoughness, *WEAR_LAWS.values(), tribo.Motion,
        tribo.Fidelity, tribo.Oil, *tribo.PINS.values(), tribo.Relief, UserLaw, UserSurface,
        SurfaceSummary,
    )
}  # fmt: skip
"""Classes whose objects a store may contain; no others are built from its data."""


def require_stored_classes(sweep: Sweep) -> None:
    """Raise an `InputError` if a part of the scene is of a class that no store keeps."""
    for name in ("pin", "loading", "roughness", "wear"):
        part = getattr(sweep.scene, name)
        if part is not None and type(part).__name__ not in _CLASSES:
            raise InputError(
                f"{name} is {part!r:.200}, of a class that a store cannot keep; set wear laws and "
                "surfaces by sweep.with_scene(wear=..., roughness=...)"
            )


def plain_sweep(sweep: Sweep) -> tuple[dict[str, Any], dict[str, Array]]:
    """Plain data of a sweep, and its measured arrays by SHA-256."""
    arrays: dict[str, Array] = {}
    plain: dict[str, Any] = encode(replace(sweep, warnings=sweep.all_warnings), arrays)
    base = plain["base"]
    plain["cases"] = [encode_difference(base, case) for case in plain["cases"]]
    for name in _WITH_CASES & plain.keys():
        plain[name] = [
            test | {"case": encode_difference(base, test["case"])} for test in plain[name]
        ]
    return plain, arrays


def sweep_of_plain(plain: Any, arrays: Mapping[str, Array]) -> Sweep:
    """The sweep of plain data from `plain_sweep`.

    Raises an `ArrayError` if an array is another one than the data name, and a `CodecError` if the
    data are those of another version of this program, see `pipeline.sweep.codec`.
    """
    try:
        base = plain["base"]
        cases = [apply_difference(base, case) for case in plain["cases"]]
        with_cases = {
            name: [test | {"case": apply_difference(base, test["case"])} for test in plain[name]]
            for name in _WITH_CASES & plain.keys()
        }
        sweep: Sweep = decode({**plain, "cases": cases, **with_cases}, _CLASSES, arrays)
    except KeyError as error:
        raise CodecError(f"this version needs {error}, which is missing there") from error
    return sweep
