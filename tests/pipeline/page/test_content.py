"""Content of a page, one file that asks for no other."""

import base64
import hashlib
import io
import json
import math
import re

import numpy as np
from PIL import Image

import pipeline
from pipeline.analysis.decisive import decisive_rise
from pipeline.cli import main
from pipeline.page.content import content
from pipeline.page.pictures import packed_point
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic


def coded(text):
    return np.array([int(code) for code in text])


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
    assert not re.search(r"@import|url\(|fetch\(|XMLHttpRequest|import\(", text)
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


def test_the_table_has_the_deciding_rise_of_each_point_at_each_share():
    held = sweeps.held()
    page = content(held)
    loads, velocities, shares = (len(page[name]) for name in ("loads", "velocities", "shares"))
    nodes = [len(page["fine"][name]) for name in ("load", "velocity")]
    rises = unpacked(page["plane"], "<f4").reshape(-1, shares)
    plane = rises[: math.prod(nodes)].reshape(*nodes, shares)
    at_points = plane[np.ix_(page["nodes"]["load"], page["nodes"]["velocity"])]
    assert at_points.shape[:2] == (loads, velocities)
    is_done = (held["status"] == 1).values
    for share in (0.0, 0.1, 0.35):
        expected = decisive_rise(held, synthetic.conditions(share)).values
        place = page["shares"].index(share)
        np.testing.assert_allclose(at_points[is_done, place], expected[is_done], rtol=1e-6)


def test_a_sweep_that_was_cut_to_the_end_of_points_has_its_page():
    ds = synthetic.sweep()
    assert content(ds.sel(step=0))["rises"] == content(ds.sel(step=[0]))["rises"]


def test_points_are_asked_for_on_their_own_surface():
    axis = "realization"
    ds = sweeps.over_surfaces(axis).isel({axis: slice(2)})
    wanted = (ds[axis] == 1) & (ds["load"] == 200.0) & (ds["velocity"] == 1.8)
    ds = ds.assign(asked=wanted.astype(np.int8))
    page = content(ds)
    asked = coded(page["asked"]).reshape(2, ds.sizes["load"], ds.sizes["velocity"])
    assert np.argwhere(asked).tolist() == [[1, 1, 4]]
    assert page["surfaces"] == [0, 1]


def test_fields_count_what_is_in_contact_alone():
    pressure = np.zeros((240, 4))
    pressure[100, 1] = 8e9
    rise = np.full((240, 4), 5000.0)
    rise[100, 1] = 1200.0
    highest, low, high, depth, *pictures = packed_point(pressure, rise, np.ones((240, 4)))
    images = [Image.open(io.BytesIO(base64.b64decode(picture))) for picture in pictures]
    p, warm, worn = (np.array(image).T[:, ::-1] for image in images)
    assert p.shape == (120, 4)
    assert (highest, low, high, depth) == (4e9, 1200.0, 1200.0, 1.0)
    assert np.argwhere(p).tolist() == np.argwhere(warm).tolist() == [[50, 1]]
    assert images[0].convert("RGB").getpixel((0, 0)) == (255, 255, 255)
    assert (worn == 255).all()


def test_fields_of_the_points_nearest_to_the_transition_are_held(tmp_path):
    ds = synthetic.sweep(fields=True)
    page = pipeline.explore(ds, tmp_path / "page.html", most_fields=5)
    assert (page.points_with_fields, page.points) == (5, 180)
    chosen = [
        divmod(int(index), ds.sizes["velocity"]) for index in content(ds, 5)["fields"]["points"]
    ]
    rise = decisive_rise(ds, synthetic.conditions()).values
    distance = np.abs(rise - synthetic.limit())
    assert sorted(distance[place] for place in chosen) == sorted(distance.ravel())[:5]


def test_the_command_writes_beside_the_store_and_says_what(alone, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.zarr").symlink_to(alone)
    assert main(["explore", "a.zarr"]) == 0
    assert capsys.readouterr().out.startswith("a.html: 9 points, 9 with fields\n")
    assert main(["explore", "a.zarr", "-o", "b.html", "--no-fields", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["path"], document["points_with_fields"]) == ("b.html", 0)
