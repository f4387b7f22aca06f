"""The next command after a result, in one line, where there is one worth running."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.sweep.model import Sweep
from pipeline.sweep.selection import PRESET_BOUNDS

if TYPE_CHECKING:
    from pipeline.analysis.margin import Margin

_COARSE = 0.05  # error of the boundary velocity from which a table is no more than a first look
_ACCURACY = "2%"


def after_run(sweep: Sweep, store: Path | str) -> str:
    """Commands that show the results of a run."""
    names = ("risk", "sensitivity") if sweep.samples else ("boundary", "plot")
    return "next: " + ", ".join(shlex.join(["irg", name, str(store)]) for name in names)


def after_boundary(attributes: Mapping[str, Any], store: Path | str) -> Iterator[str]:
    """Command for a boundary of a higher accuracy, where that of the preset is low."""
    bound = _bound(attributes)
    if bound > _COARSE:
        yield (
            f"preset {attributes['preset']}: velocities may err by {100 * bound:g} %; next: "
            f"{_more_accurate(attributes, store)}"
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
