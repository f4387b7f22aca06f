"""The notebooks: run to their end, the one of samples on fewer, and are kept without output."""

import json
from pathlib import Path

import pytest

import pipeline

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
WORKFLOWS = Path(__file__).parents[2] / "workflows"
NOTEBOOK = WORKFLOWS / "uncertain.ipynb"
SHORT = ["first_diagram.ipynb", "stations.ipynb"]


@pytest.mark.parametrize("name", [NOTEBOOK.name, *SHORT])
def test_a_notebook_is_kept_without_what_it_printed(name):
    cells = json.loads((WORKFLOWS / name).read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert len(code) > 4
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


def test_the_notebook_leads_from_transitions_to_a_map_and_the_next_test(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    first = next(cell for cell in notebook.cells if cell.cell_type == "code")
    assert "SAMPLES = 128" in first.source
    first.source = first.source.replace("SAMPLES = 128", "SAMPLES = 16")
    folder = {"metadata": {"path": str(tmp_path)}}  # any one, without the scenes
    nbclient.NotebookClient(notebook, timeout=200, startup_timeout=60, resources=folder).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    printed = "".join(output.text for output in outputs if output.output_type == "stream")
    figures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(figures) == 4
    ensemble = pipeline.Ensemble.of(pipeline.open_sweep(tmp_path / "results" / "uncertain.zarr"))
    prior = pipeline.risk(ensemble, 400.0, 2.0)
    assert f"{prior.probability:.2f} ± {prior.error:.2f}\n" in printed
    posterior = pipeline.risk(ensemble, 400.0, 2.0, pipeline.posterior(ensemble).draws)
    sentence = (
        f"{posterior.probability:.2f} ± {posterior.error:.2f} instead of {prior.probability:.2f}\n"
    )
    assert sentence in printed
    assert printed.count("% instead of ±") == 6


def test_the_short_notebooks_keep_their_assertions(tmp_path):
    """In one kernel, which imports once."""
    both = [nbformat.read(WORKFLOWS / name, as_version=4) for name in SHORT]
    assert all(sum("assert " in cell.source for cell in one.cells) >= 2 for one in both)
    notebook = both[0].copy()
    notebook.cells = [cell for one in both for cell in one.cells]
    folder = {"metadata": {"path": str(tmp_path)}}  # any one, without the scenes
    nbclient.NotebookClient(notebook, timeout=200, startup_timeout=60, resources=folder).execute()
    first, stations = (str([cell.get("outputs", []) for cell in one.cells]) for one in both)
    assert "image/png" in first
    assert "image/png" in stations
    assert "/status" in stations  # the link of the dashboard
