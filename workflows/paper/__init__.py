"""Every figure and table of the paper, recomputed, beside what it prints.

`RESULTS` are their names; `reproduce` computes one; `write_gallery` all of them, and the page that
shows them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from pipeline.figures.style import figure_path, save_figure
from pipeline.scene.entries import did_you_mean
from pipeline.scene.shipped import WORKFLOWS
from pipeline.sweep.stages import staged
from tribo import PRESETS, InputError
from workflows.paper.gallery import page
from workflows.paper.held_load import fig5
from workflows.paper.line_pressure import fig4
from workflows.paper.load_record import fig8
from workflows.paper.measured import inverse
from workflows.paper.report import Finding, Report, Table
from workflows.paper.resolution import fig6
from workflows.paper.rivals import rivals
from workflows.paper.sensitivity import sensitivity
from workflows.paper.study import Study
from workflows.paper.surface_band import band
from workflows.paper.table_4 import table4
from workflows.paper.table_6 import table6
from workflows.paper.transition_diagram import fig10

__all__ = ["RESULTS", "Finding", "Report", "Study", "Table", "reproduce", "write_gallery"]

_MAKERS: dict[str, tuple[Callable[[Study], Report], str]] = {
    "fig4": (fig4, "pressure of a cylinder: free ends, nearest images, all images, Hertz"),
    "fig5": (fig5, "highest temperature through a ramp and a hold, with and without wear"),
    "fig6": (fig6, "highest temperature against the number of elements and of increments"),
    "fig8": (fig8, "a recorded load (synthetic) and its linear fit"),
    "fig10": (fig10, "the transition diagram, with the measured transitions"),
    "band": (band, "the transition over several surfaces, and within the measured friction"),
    "table4": (table4, "contact width, failed share and temperatures at the transitions"),
    "table6": (table6, "temperatures at the transitions of oil A, at 25 and 100 °C"),
    "rivals": (rivals, "simpler criteria at the transitions: Blok, power, PV, and the film"),
    "sensitivity": (
        sensitivity,
        "to correlation length, lay, Hurst exponent and Ra of the roughness",
    ),
    "inverse": (inverse, "critical temperature, wear rate and rig heating from measurements"),
}

RESULTS: dict[str, str] = {name: what for name, (_, what) in _MAKERS.items()}
"""What can be reproduced, by name, in a line each."""


def reproduce(
    name: str,
    out: str | Path | None = None,
    *,
    preset: str | None = None,
    surfaces: int | None = None,
    workers: int | None = None,
    scenes: str | Path = WORKFLOWS,
    results: str | Path = "results",
    progress: Callable[[str], None] | None = None,
) -> Report:
    """Compute a figure or table of the paper.

    Parameters
    ----------
    name : str
        One of `RESULTS`.
    out : path, optional
        File to write the figure to; .pdf, .png or .svg.
    preset : str, optional
        Fidelity in place of the one that belongs to the result.
    surfaces : int, optional
        Number of random surfaces in place of the result's own.
    workers : int, optional
        Number of workers for a sweep; one for each core if not given.
    scenes, results : path
        Folders of the scene files and of the stores.
    progress : callable, optional
        Called with a line on what comes next.

    Raises
    ------
    InputError
        If the name, the preset, the number of surfaces or the suffix cannot be, or a scene is
        missing; besides what the simulation raises.

    Examples
    --------
    >>> from workflows import paper
    >>> print(paper.reproduce("fig4"))  # doctest: +SKIP
    """
    if name not in _MAKERS:
        raise InputError(
            f"{name!r} is not a figure or table{did_you_mean(name, _MAKERS)}; "
            f"there are {', '.join(_MAKERS)}"
        )
    if preset is not None and preset not in PRESETS:
        raise InputError(
            f"preset is {preset!r}{did_you_mean(preset, PRESETS)}; allowed are {', '.join(PRESETS)}"
        )
    if surfaces is not None and not 1 <= surfaces <= 1000:
        raise InputError(f"surfaces is {surfaces!r}; it must be from 1 to 1000")
    file = None if out is None else figure_path(out)
    began = time.perf_counter()
    study = Study(
        scenes=Path(scenes),
        results=Path(results),
        preset=preset,
        surfaces=surfaces,
        workers=workers,
        tell=progress or (lambda line: None),
    )
    report = _MAKERS[name][0](study)
    if file is not None:
        save_figure(report.figure, file)
    return replace(report, seconds=time.perf_counter() - began, file=file)


def write_gallery(
    folder: str | Path,
    names: Iterable[str] = RESULTS,
    *,
    preset: str | None = None,
    surfaces: int | None = None,
    workers: int | None = None,
    scenes: str | Path = WORKFLOWS,
    results: str | Path = "results",
    progress: Callable[[str], None] | None = None,
) -> list[Report]:
    """Compute every result, and write its figure and the page that shows them.

    Parameters
    ----------
    folder : path
        Folder for ``README.md`` and the figures; made if it does not exist.
    names : iterable of str
        Names of the results to write, all if not given.
    preset, surfaces, workers, scenes, results, progress
        See `reproduce`.

    Examples
    --------
    >>> from workflows import paper
    >>> paper.write_gallery("gallery", ["fig4", "table4"])  # doctest: +SKIP
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write to {folder}: {error.strerror or error}") from error
    reports = []
    for name in staged(names, progress, lambda name: f"{name}: {RESULTS.get(name, '')}"):
        report = reproduce(
            name,
            folder / f"{name}.png",
            preset=preset,
            surfaces=surfaces,
            workers=workers,
            scenes=scenes,
            results=results,
            progress=progress,
        )
        reports.append(report)
    (folder / "README.md").write_text(page(reports), encoding="utf-8")
    return reports
