"""Every figure and table of the paper, recomputed, beside what it prints.

`RESULTS` are their names; `reproduce` computes one; `write_gallery` all of them, and the page that
shows them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from pipeline.figures.style import save_figure
from pipeline.messages import did_you_mean
from pipeline.paths import FIGURES, writable_path
from tribo import InputError

from .checkerboard import fig2
from .contra import contra
from .ends import ends
from .errata import errata
from .gallery import pages
from .held_load import fig5
from .heldout import heldout
from .inference import inverse
from .line_pressure import fig4
from .load_record import fig8
from .recomputed import WORDS, Recomputation
from .resolution import fig6
from .rivals import rivals
from .spacing import spacing
from .steel import steel
from .study import Study, with_progress
from .table_4 import table4
from .table_6 import table6
from .transition_diagram import fig10

RESULTS: dict[str, str] = {
    name: words["summary"] for name, words in WORDS.items() if "summary" in words
}
"""Results that can be reproduced, by name, in a line each."""

NOT_REPRODUCED: dict[str, str] = WORDS["not_reproduced"]
"""Figures and tables of the paper that no model gives, by name, with the reason."""

_MAKERS: dict[str, Callable[[Study], Recomputation]] = {
    maker.__name__: maker
    for maker in (
        *(errata, fig2, fig4, fig5, fig6, fig8, fig10),
        *(table4, table6, heldout, rivals, inverse, steel, spacing, ends, contra),
    )
}


def reproduce(name: str, out: str | Path | None = None, **choices: Any) -> Recomputation:
    """Compute a figure or table of the paper.

    Parameters
    ----------
    name : str
        One of `RESULTS`.
    out : path, optional
        File to write the figure to, .pdf, .png or .svg; or a folder, for a file NAME.png in it.
    **choices
        Fields of `Study`, such as ``preset`` and ``surfaces``.

    Raises
    ------
    InputError
        If the name, the preset, the number of surfaces or the suffix cannot be, or a scene is
        missing; besides what the simulation raises.

    Examples
    --------
    >>> print(reproduce("fig4").title)
    pressure of a cylinder of radius 8 mm, in a window of 0.456 mm
    """
    if name in NOT_REPRODUCED:
        raise InputError(f"{name} is not recomputed: {NOT_REPRODUCED[name]}")
    if name not in _MAKERS:
        raise InputError(
            f"{name!r} is not a figure or table{did_you_mean(name, _MAKERS)}; "
            f"available: {', '.join(_MAKERS)}"
        )
    study = Study(**choices)
    if out is not None and Path(out).is_dir():
        out = Path(out, f"{name}.png")
    file = None if out is None else writable_path(out, FIGURES)
    began = time.perf_counter()
    report = _MAKERS[name](study)
    if file is not None:
        save_figure(report.figure, file)
        if file.suffix == ".png":
            _make_smaller(file)
    return replace(report, seconds=time.perf_counter() - began, file=file)


def _make_smaller(file: Path) -> None:
    """Write a picture again with few colours: a third of its size, in the repository."""
    with Image.open(file) as picture:
        method, metadata = Image.Quantize.MEDIANCUT, PngInfo()
        for keyword, text in picture.text.items():  # type: ignore[attr-defined]
            metadata.add_text(keyword, text)
        few = picture.convert("RGB").quantize(256, method, dither=Image.Dither.NONE)
    few.save(file, optimize=True, pnginfo=metadata)


def write_gallery(
    folder: str | Path, names: Iterable[str] = RESULTS, **choices: Any
) -> list[Recomputation]:
    """Compute results, and write their figures and the pages that show them.

    Parameters
    ----------
    folder : path
        Folder for the pages and figures; made if it does not exist.
    names : iterable of str
        Names of the results to compute, all if not given. What the pages say of others stays.
    **choices
        Fields of `Study`.

    Examples
    --------
    >>> write_gallery("gallery", ["fig4", "table4"])  # doctest: +SKIP
    """
    folder, progress = Path(folder), Study(**choices).progress
    if folder.suffix.lower() in FIGURES:
        raise InputError(f"cannot write all results to the file {folder}; name a folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write to {folder}: {error.strerror or error}") from error
    reports = [
        reproduce(name, folder, **choices)
        for name in with_progress(names, progress, lambda name: f"{name}: {RESULTS.get(name, '')}")
    ]
    for name, text in pages(reports).items():
        (folder / name).write_text(text, encoding="utf-8")
    return reports
