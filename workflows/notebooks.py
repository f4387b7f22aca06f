"""Run the notebooks of this folder, and store what their cells show; ``make notebooks``.

Printed lines, results and figures are stored. Progress and messages on stderr differ from run to
run, and are left out.
"""

from __future__ import annotations

import base64
import io
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).parent
_WIDEST, _COLOURS = 760, 128  # width [pixel] and colours of a figure: some 35 kB each
_TIMEOUT = 1200  # most seconds that a cell may take


def run(path: Path) -> None:
    """Run a notebook in an empty folder, and write its file anew with the outputs of cells."""
    notebook = nbformat.read(path, as_version=4)
    source_metadata = dict(notebook.metadata)  # the kernel adds its version
    with TemporaryDirectory() as folder:
        client = NotebookClient(
            notebook,
            timeout=_TIMEOUT,
            record_timing=False,
            resources={"metadata": {"path": folder}},
        )
        # What it does for the output of `interact` makes it wait for ever (nbclient issue 312).
        client.widget_registry = {}
        client.execute()
    notebook.metadata = nbformat.from_dict(source_metadata)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if _is_kept(output)]
            for output in cell.outputs:
                data = output.get("data", {})
                if "image/png" in data:
                    output.data = nbformat.from_dict({"image/png": _smaller(data["image/png"])})
    nbformat.validate(notebook)
    nbformat.write(notebook, path)


def _is_kept(output: Any) -> bool:
    return output.output_type == "execute_result" or output.get("name") == "stdout"


def _smaller(encoded: str) -> str:
    """A figure, as base64 text of a .png, with fewer pixels and colours."""
    picture = Image.open(io.BytesIO(base64.b64decode(encoded))).convert("RGB")
    picture.thumbnail((_WIDEST, 2 * _WIDEST), Image.Resampling.LANCZOS)
    written = io.BytesIO()
    picture.quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        written, "png", optimize=True
    )
    return base64.b64encode(written.getvalue()).decode("ascii")


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(path.stem for path in FOLDER.glob("*.ipynb")):
        print(name, flush=True)
        run(FOLDER / f"{name}.ipynb")
