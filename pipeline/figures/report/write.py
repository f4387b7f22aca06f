"""A report as a file: HTML in one piece, which a browser prints."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from pipeline.analysis.dataset import attributes_of, dataset_of
from pipeline.analysis.tables import writable_path, write_text
from pipeline.figures.report.content import content
from pipeline.scene.along import OperatingPoints
from pipeline.store.place import PathLike

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 50rem;
       margin: 2rem auto; padding: 0 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.2; } h2 { font-size: 1.15rem; margin-top: 2rem; }
figure { margin: 0; } svg { width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 0.9rem; display: block;
        overflow-x: auto; }
th, td { text-align: left; padding: 0.25rem 0.8rem 0.25rem 0; vertical-align: top;
         border-bottom: 1px solid #e4e4e4; }
th { border-bottom: 2px solid #777; width: auto; }
@page { size: A4; margin: 16mm 18mm;
        @bottom-center { content: counter(page) " / " counter(pages); font: 8pt sans-serif; } }
@media print {
  body { font-size: 9pt; line-height: 1.35; max-width: none; margin: 0; padding: 0; }
  h2 { margin: 5mm 0 1mm; } p, table { margin: 1.5mm 0; }
  th, td { padding: 0.5mm 3mm 0.5mm 0; }
  h1, h2 { break-after: avoid; } tr, figure { break-inside: avoid; }
  svg { max-height: 16cm; }
  table { display: table; width: 100%; font-size: 7.5pt; } thead { display: table-header-group; }
}
"""


def report(
    ds: xr.Dataset | PathLike,
    out: str | Path,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]] | None = None,
    **conditions: Any,
) -> Path:
    """Write a report of a sweep, for people without the tool: one file of HTML.

    It holds the question and its answer, the diagram, the boundary in numbers, the margins of
    operating points, warnings, inputs with their units and sources, numerical choices and their
    error, versions, and how to cite.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store.
    out : str or path
        File to write, .html; a browser prints it on A4 or to PDF.
    points : path or mapping of str to sequence, optional
        Operating points whose margins to tell; see `pipeline.margin_table`.
    **conditions
        Friction, temperatures, share and criterion in place of the sweep's own; see
        `pipeline.boundary`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the suffix is another one, the file cannot be written, or the operating points or
        conditions are faulty.

    Examples
    --------
    >>> import pipeline
    >>> points = {"load": ["500 N"], "velocity": ["1.6 m/s"]}
    >>> pipeline.report("results/first_try.zarr", "results/report.html", points).name
    'report.html'
    """
    path = writable_path(out, (".html",))
    if points is not None and not isinstance(points, OperatingPoints):
        points = OperatingPoints.read(points)
    ds = dataset_of(ds)
    body, title = content(ds, points, conditions), str(attributes_of(ds).get("title") or path.stem)
    document = (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )
    return write_text(document, path)
