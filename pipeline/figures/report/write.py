"""A report as a file: HTML in one piece, or PDF."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import dataset_of
from pipeline.analysis.operating_points import OperatingPoints
from pipeline.analysis.tables import writable_path, write_text, writing_to
from pipeline.figures.report.content import content
from pipeline.store.place import PathLike

_SUFFIXES = (".html", ".pdf")
_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 50rem;
       margin: 2rem auto; padding: 0 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.2; } h2 { font-size: 1.15rem; margin-top: 2rem; }
img { width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 0.9rem; display: block;
        overflow-x: auto; }
th, td { text-align: left; padding: 0.25rem 0.8rem 0.25rem 0; vertical-align: top;
         border-bottom: 1px solid #e4e4e4; }
th { border-bottom: 2px solid #777; width: auto; }
@media print { h2 { break-after: avoid; } table, img { break-inside: avoid; } }
"""


def report(
    ds: xr.Dataset | PathLike,
    out: str | Path,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]] | None = None,
    **conditions: Any,
) -> Path:
    """Write a report of a sweep, for people without the tool: one file of HTML or PDF.

    It holds the question and its answer, the diagram, the boundary in numbers, the margins of
    operating points, warnings, inputs with their units and sources, numerical choices and their
    error, versions, and how to cite.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store.
    out : str or path
        File to write, .html or .pdf.
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
    path = writable_path(out, _SUFFIXES)
    if points is not None and not isinstance(points, OperatingPoints):
        points = OperatingPoints.read(points)
    ds = dataset_of(ds)
    body, title = content(ds, points, conditions), str(attributes_of(ds).get("title") or path.stem)
    if path.suffix.lower() == ".pdf":
        return _write_pdf(body, title, path)
    document = (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )
    return write_text(document, path)


def _write_pdf(body: str, title: str, path: Path) -> Path:
    """Write the document as pages of A4."""
    import fpdf

    class Pages(fpdf.FPDF):
        """Pages with their numbers."""

        def footer(self) -> None:
            """Write the number of a page."""
            self.set_y(-12)
            self.set_font("DejaVu", size=8)
            self.cell(0, 6, f"{self.page_no()} / {{nb}}", align="C")

    pages = Pages(format="A4")
    pages.set_title(title)
    pages.set_lang("en")
    fonts = Path(mpl.get_data_path(), "fonts", "ttf")
    for style, ending in (("", ""), ("B", "-Bold"), ("I", "-Oblique"), ("BI", "-BoldOblique")):
        pages.add_font("DejaVu", style, fonts / f"DejaVuSans{ending}.ttf")
    pages.set_margins(18, 16)
    pages.set_auto_page_break(True, margin=18)
    pages.set_font("DejaVu", size=8.5)
    pages.add_page()
    headings = {
        name: fpdf.TextStyle(font_style="B", font_size_pt=size, t_margin=4, b_margin=2)
        for name, size in (("h1", 16), ("h2", 12), ("h3", 10))
    }
    body = body.replace("<td>", '<td align="left">').replace("<th ", '<th align="left" ')
    pages.write_html(body, table_line_separators=True, tag_styles=headings)
    with writing_to(path):
        pages.output(str(path))
    return path
