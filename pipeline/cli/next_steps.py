"""The next command after a result, in one line, where there is one worth running."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import asked
from pipeline.analysis.transition import ENTRIES
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.selection import PRESET_BOUNDS

if TYPE_CHECKING:
    import xarray as xr

    from pipeline.analysis.margin import Margin

_COARSE = 0.05  # error of the boundary velocity from which a table is no more than a first look
_ACCURACY = "2%"
_BULKS = {
    "bulk_temperature": "temperature.bulk.pin",
    "disk_temperature": "temperature.bulk.disk",
}


def after_boundary(attributes: Mapping[str, Any], store: Path | str) -> Iterator[str]:
    """Command for a boundary of a higher accuracy, where that of the preset is low."""
    bound = _bound(attributes)
    if bound > _COARSE:
        yield (
            f"preset {attributes['preset']}: velocities may err by up to {100 * bound:g} %, "
            f"as irg trade measures on a scene; next: {_more_accurate(attributes, store)}"
        )


def after_margin(
    attributes: Mapping[str, Any], store: Path | str, margins: Iterable[Margin]
) -> Iterator[str]:
    """Command that decides a margin which is smaller than the error of the preset."""
    bound = _bound(attributes)
    if any(abs(margin.velocity_factor - 1) < bound for margin in margins):
        yield (
            f"nearer to the boundary than preset {attributes['preset']} may err "
            f"({100 * bound:g} %); next: {_more_accurate(attributes, store)}"
        )


def more_of_boundary(ds: xr.Dataset, store: Path | str, conditions: Mapping[str, Any]) -> str:
    """Command that computes more of a boundary under some conditions: first its missing points."""
    attributes = attributes_of(ds)
    missing = {int(status) for status in ds["status"].values[asked(ds).values]} - {DONE}
    settings = [] if missing else _settings(attributes.get("conditions") or {}, conditions)
    replaced = tuple(setting[: setting.rindex("=") + 1] for setting in settings)
    words = attributes.get("arguments") or [f"{attributes.get('name')}.toml"]
    words = [word for word in words if not (replaced and word.startswith(replaced))]
    if selection := attributes.get("selection"):
        words.append(f"--accuracy={selection['accuracy']:g}")
    words += ["-o", str(store)]
    if attributes.get("boundary_only") or not missing:
        words.append("--boundary-only")
    if FAILED in missing:
        words.append("--retry-failed")
    return shlex.join(["irg", "run", *words, *settings])


def next_tests(
    stores: Iterable[Path | str], scatter: float | None = None, target: str | None = None
) -> str:
    """Command that ranks tests, of samples weighed in the same way."""
    words = ["irg", "infer", *map(str, stores), "--next"]
    words += ["--for", target] if target else []
    return shlex.join(words if scatter is None else [*words, f"--scatter={scatter:g}"])


def _settings(stored: Mapping[str, Any], conditions: Mapping[str, Any]) -> list[str]:
    """Settings of the conditions that differ from those of a store."""
    entries = ENTRIES
    if "disk_temperature" in stored:
        entries = entries | _BULKS
        conditions = {"disk_temperature": conditions["bulk_temperature"], **conditions}
    stored = {"criterion": "share", **stored}
    settings = []
    for name, entry in entries.items():
        value = conditions.get(name)
        if value is not None and stored.get(name) != value:
            text = value if isinstance(value, str) else repr(float(value))
            if name.endswith("temperature"):
                text = f"{value - 273.15:.6g} degC"
            settings.append(f"--set={entry}={text}")
            if name == "criterion" and ":" in text:
                settings.append("--own-laws")
    return settings


def _bound(attributes: Mapping[str, Any]) -> float:
    """Error of the boundary velocity that the preset of a store keeps to; 0 if unknown."""
    if attributes.get("selection"):
        return 0.0
    return PRESET_BOUNDS.get(str(attributes.get("preset")), 0.0)


def _more_accurate(attributes: Mapping[str, Any], store: Path | str) -> str:
    scene = attributes.get("arguments") or [f"{attributes.get('name')}.toml"]
    kept = [word for word in scene if not word.startswith(("--preset=", "--set=preset="))]
    out = str(store).removesuffix(".zarr") + "_accurate.zarr"
    return shlex.join(["irg", "run", *kept, f"--accuracy={_ACCURACY}", "-o", out])
