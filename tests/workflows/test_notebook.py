"""The notebooks: run to their end, the one of samples on fewer, and are kept without output."""

import json
from pathlib import Path

import pytest

import pipeline
from tests.helpers.samples import fewer_draws

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
WORKFLOWS = Path(__file__).parents[2] / "workflows"
UNCERTAIN = "uncertain.ipynb"
SHORT = ["first_diagram.ipynb", "stations.ipynb"]
NAMES = [UNCERTAIN, *SHORT]
SMALLER = {
    UNCERTAIN: ("SAMPLES = 128", "SAMPLES = 16"),
    "stations.ipynb": (
        '"sweep.fields": True',
        '"sweep.fields": True, "sweep.loads": ["600 N", "750 N"], "sweep.velocities": ["1.6 m/s"]',
    ),
}
FIRST = f"""
import atexit, sys
sys.path.insert(0, {str(WORKFLOWS.parent)!r})
import pytest
import pipeline.run.sweep
from tests.helpers.samples import fewer_draws
from tests.helpers.workers import Workers
fewer_draws(pytest.MonkeyPatch())
workers = Workers()
pipeline.run.sweep.connected = workers.connected
atexit.register(workers.end)
"""
"""What notebooks share as tests do: draws and workers."""


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_kept_without_what_it_printed(name):
    cells = json.loads((WORKFLOWS / name).read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert len(code) > 4
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """The folder in which they ran, of all the same, and the outputs of each: in one kernel."""
    read = {name: nbformat.read(WORKFLOWS / name, as_version=4) for name in NAMES}
    for name, (large, small) in SMALLER.items():
        first = next(cell for cell in read[name].cells if cell.cell_type == "code")
        assert large in first.source
        first.source = first.source.replace(large, small)
    together = read[UNCERTAIN].copy()
    together.cells = [cell for name in (*SHORT, UNCERTAIN) for cell in read[name].cells]
    together.cells.insert(0, nbformat.v4.new_code_cell(FIRST))
    folder = tmp_path_factory.mktemp("notebooks")  # without the scenes
    resources = {"metadata": {"path": str(folder)}}
    nbclient.NotebookClient(
        together, timeout=200, startup_timeout=60, resources=resources
    ).execute()
    outputs = {
        name: [output for cell in read[name].cells for output in cell.get("outputs", [])]
        for name in NAMES
    }
    return folder, outputs


def test_the_notebook_leads_from_transitions_to_a_map_and_the_next_test(executed, monkeypatch):
    folder, outputs = executed[0], executed[1][UNCERTAIN]
    fewer_draws(monkeypatch)
    printed = "".join(output.text for output in outputs if output.output_type == "stream")
    figures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(figures) == 4
    ensemble = pipeline.Ensemble.of(pipeline.open_sweep(folder / "results" / "uncertain.zarr"))
    prior = pipeline.risk(ensemble, 400.0, 2.0)
    assert f"{prior.probability:.2f} ± {prior.error:.2f}\n" in printed
    posterior = pipeline.risk(ensemble, 400.0, 2.0, pipeline.posterior(ensemble).draws)
    sentence = (
        f"{posterior.probability:.2f} ± {posterior.error:.2f} instead of {prior.probability:.2f}\n"
    )
    assert sentence in printed
    assert printed.count("% instead of ±") == 6


def test_the_short_notebooks_keep_their_assertions(executed):
    for name in SHORT:
        source = (WORKFLOWS / name).read_text(encoding="utf-8")
        assert source.count("assert ") >= 2
    first, stations = (str(executed[1][name]) for name in SHORT)
    assert "image/png" in first
    assert "image/png" in stations
    assert "/status" in stations  # the link of the dashboard
