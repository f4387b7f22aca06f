"""Content of a page, one file that asks for no other."""

import base64
import hashlib
import json
import re

import numpy as np

import pipeline
from pipeline.cli import main
from pipeline.page.content import content
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.helpers.sweeps import deciding_rise


def unpacked(text, dtype):
    return np.frombuffer(base64.b64decode(text), dtype)


def test_a_page_is_one_file_that_names_no_address_and_runs_its_own_script_alone(tmp_path):
    title = '</script><script>alert("1")</script><!-- & é ${data} \u2028'
    ds = synthetic.sweep(title=title)
    ds["message"][0, 0] = title
    page = pipeline.explore(ds, tmp_path / "page.html")
    text = page.path.read_text()
    assert re.findall(r"https?://[^\"'\s]*", text) == ["http://www.w3.org/2000/svg"]
    assert not re.search(r"\b(src|href)=", text)
    assert not re.search(r"@import|url\((?!#)|fetch\(|XMLHttpRequest|import\(", text)
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    for name in ("script", "style"):
        (source,) = re.findall(rf"<{name}>(.*?)</{name}>", text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(source.encode()).digest()).decode()
        assert f"{name}-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'")
    (held,) = re.findall(r'id="content">(.*?)</script>', text, re.DOTALL)
    assert "<" not in held
    assert json.loads(held)["messages"] == {"0": title}
    assert len(re.findall("<script", text)) == 2


def test_the_table_has_the_deciding_rise_of_each_point():
    held = sweeps.held()
    page = content(held)
    nodes = [len(page["fine"][name]) for name in ("load", "velocity")]
    plane = np.exp(unpacked(page["plane"], "<f4").reshape(nodes))
    at_points = plane[np.ix_(page["nodes"]["load"], page["nodes"]["velocity"])]
    is_done = (held["status"] == 1).values
    expected = deciding_rise(held, synthetic.conditions()).values
    np.testing.assert_allclose(at_points[is_done], expected[is_done], rtol=2e-6)


def test_a_sweep_that_was_cut_to_the_end_of_points_has_its_page():
    ds = synthetic.sweep()
    assert content(ds.sel(step=0))["rises"] == content(ds.sel(step=[0]))["rises"]


def test_the_command_writes_beside_the_store_and_says_what(alone, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.zarr").symlink_to(alone)
    assert main(["explore", "a.zarr"]) == 0
    assert capsys.readouterr().out.startswith("a.html: 9 points, 9 with fields\n")
    assert main(["explore", "a.zarr", "-o", "b.html", "--no-fields", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["path"], document["points_with_fields"]) == ("b.html", 0)


def test_points_are_those_of_the_first_surface():
    ds = sweeps.over_surfaces().isel(realization=slice(2))
    wanted = (ds["realization"] == 0) & (ds["load"] == 200.0) & (ds["velocity"] == 1.8)
    page = content(ds.assign(asked=wanted.astype(np.int8)))
    asked = np.array([*map(int, page["asked"])]).reshape(ds.sizes["load"], ds.sizes["velocity"])
    assert np.argwhere(asked).tolist() == [[1, 4]]
    first = content(ds.isel(realization=0))
    assert (page["rises"], page["times"]) == (first["rises"], first["times"])


def test_a_reader_without_the_program_is_told_to_type_nothing(tmp_path):
    pipeline.explore(synthetic.sweep(preset="standard"), tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text("utf-8")
    shown = re.sub(r"<script.*?</script>|<style.*?</style>|<[^>]*>", "", text, flags=re.DOTALL)
    assert "are taken as exact" in shown
    assert re.findall(r"\birg (?!transition)\w+", shown) == []
