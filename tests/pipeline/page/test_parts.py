"""Parts of a page: its form, its pictures, the states of its nodes, and what it is said to hold."""

import base64
import io
import json
import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
import xarray as xr
from PIL import Image

import pipeline
from pipeline.analysis.dataset import stored_sweep
from pipeline.analysis.field import fields
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.model_error import ModelError
from pipeline.analysis.words import boundary_lines, next_run_lines
from pipeline.page.content import (
    along,
    content,
    digit_string,
    divided,
    packed_array,
    pieces_of,
    states,
)
from pipeline.page.controls import controls, scene_choice, surface_choice
from pipeline.page.pictures import coloured, packed_fields, packed_point
from pipeline.store.schema import DONE
from pipeline.sweep.digest import digest
from tests.helpers import page_sweeps as sweeps
from tests.helpers import samples, synthetic
from tests.helpers.entries import two_pins
from tests.helpers.sweeps import with_fields
from tribo import InputError

OWN = synthetic.conditions()


def form(conditions=OWN, has_heat=True, two_bulks=False, has_share=True):
    made = controls(conditions, has_heat, two_bulks, has_share)
    return {one.name: one for one in made}


# The form


def test_each_condition_has_a_slider_about_its_value_and_bounds():
    made = form()
    assert [*made] == ["friction", "bulk_temperature", "critical_temperature", "failing_share"]
    friction, bulk, critical, share = made.values()
    assert (friction.low, friction.high, friction.step) == (0.0, 0.3, 0.001)
    assert (friction.least, friction.most, friction.fault) == (0.0, None, "must be at least 0")
    assert (bulk.low, bulk.high, bulk.step, bulk.offset) == (0.0, 200.0, 0.5, -273.15)
    assert bulk.label == "bulk temperature [°C]"
    assert bulk.fault == f"from {bulk.least - 273.15:.2f} to {bulk.most - 273.15:.2f} °C".replace(
        "-", "−"
    )
    assert (critical.low, critical.high) == (0.0, 400.0)
    assert (share.low, share.high, share.factor) == (0.0, 50.0, 100.0)
    assert (share.least, share.most < 1.0, share.most > 0.9999) == (0.0, True, True)
    assert (critical.offset, critical.step, share.step) == (-273.15, 0.5, 0.5)
    assert [(one.factor, one.offset) for one in (friction, share)] == [(1.0, 0.0), (100.0, 0.0)]
    assert critical.factor == 1.0
    assert share.label == "failing share of the contact [%]"


@pytest.mark.parametrize(
    ("friction", "high"), [(0.14, 0.3), (0.15, 0.3), (0.151, 0.4), (0.5, 1.0), (0.0, 0.3)]
)
def test_the_slider_of_friction_reaches_twice_its_value(friction, high):
    assert form(replace(OWN, friction=friction))["friction"].high == pytest.approx(high)


def test_sliders_of_temperatures_reach_below_and_above_them():
    cold = replace(OWN, bulk_temperature=273.15 - 15.0, critical_temperature=273.15 + 300.0)
    made = form(cold)
    assert made["bulk_temperature"].low == -20.0
    assert made["critical_temperature"].high == 450.0
    unknown = form(replace(OWN, critical_temperature=None))["critical_temperature"]
    assert (unknown.low, unknown.high) == (0.0, 400.0)
    assert form(replace(OWN, failing_share=0.602))["failing_share"].high == 61.0


def test_without_heat_friction_stays_0_and_two_bulks_have_two_controls():
    made = form(has_heat=False, two_bulks=True, has_share=False)
    assert [*made] == ["friction", "bulk_temperature", "disk_temperature", "critical_temperature"]
    assert made["friction"].most == 0.0
    assert made["friction"].fault.startswith("must be 0: the sweep was computed without friction")
    assert made["bulk_temperature"].label == "bulk temperature of the pin [°C]"
    assert made["disk_temperature"].label == "bulk temperature of the disk [°C]"
    warm = form(replace(OWN, disk_temperature=493.25, critical_temperature=600.0), two_bulks=True)
    assert warm["disk_temperature"].high == 331.0  # half more than 220.1 °C


def test_a_control_is_a_slider_and_a_field_with_its_ends():
    text = form()["friction"].html()
    assert 'id="friction-range" min="0" max="0.3" step="0.001"' in text
    assert '<label for="friction">friction coefficient</label>' in text
    assert 'id="friction-fault" role="alert"' in text


def test_surfaces_and_scenes_are_chosen_among_where_there_are_several():
    assert (
        surface_choice(None) == surface_choice([7]) == scene_choice([]) == scene_choice([""]) == ""
    )
    options = re.findall(r'<option value="(.*?)">(.*?)</option>', surface_choice([7, 9]))
    assert options == [("", "all 2 surfaces"), ("0", "surface 7"), ("1", "surface 9")]
    options = re.findall(r'<option value="(.*?)">(.*?)</option>', scene_choice(["a < b", "c"]))
    assert [(value, unescape(text)) for value, text in options] == [("0", "a < b"), ("1", "c")]


# Words


def test_a_page_says_what_it_holds(tmp_path):
    page = pipeline.explore(synthetic.sweep(fields=True), tmp_path / "page.html", 6)
    assert str(page).endswith("page.html: 180 points, 6 with fields")
    assert page.as_dict()["path"] == str(tmp_path / "page.html")
    page = pipeline.explore(sweeps.over_surfaces(), tmp_path / "page.html")
    assert str(page).endswith(" points")
    assert "10 to 90 % of 5 surfaces" in page.path.read_text()


def text_of(ds, folder, **options):
    """Text of a page of a sweep, without tags."""
    written = pipeline.explore(ds, folder / "page.html", **options).path.read_text()
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", written)).split())


def test_a_page_has_the_answer_the_inputs_and_the_origin_in_words(tmp_path):
    picked = synthetic.selection(error=0.01)
    ds = synthetic.sweep(preset=None, selection=picked).assign_attrs(history="Computed here")
    ds["status"][0, 0] = 0
    text = text_of(ds, tmp_path)
    sweep = stored_sweep(ds)
    found = pipeline.boundary(ds)
    boundary = [*next_run_lines(found), *boundary_lines(found)]
    for words in (
        *(line[1:] for line in boundary), "1 points are pending or failed",
        "pin.radius 2 mm Radius in the plane of sliding", "Young's modulus",
        "Numerical choices: ", str(picked)[1:], "Computed here.", digest(sweep.scene),
    ):  # fmt: skip
        assert words in text


def test_a_duty_that_cannot_be_judged_is_named_and_the_others_are_shown(tmp_path):
    duties = {"load [N]": [400.0, 5000.0], "velocity [m/s]": [2.0, 1.0], "part": ["a", "b"]}
    text = text_of(synthetic.sweep(), tmp_path, points=duties)
    table = pipeline.margin(synthetic.sweep(), duties)
    assert table["verdict"].to_list() == ["not decided", "not known"]
    assert f"{table['distance [K]'][0]:.4g}" in text
    assert "5000 N at 1 m/s: load is 5000 N; the sweep has 200 to 750 N" in text


def test_without_a_critical_temperature_a_page_says_what_is_not_known(tmp_path):
    ds = synthetic.sweep(conditions=replace(OWN, critical_temperature=None))
    text = text_of(ds, tmp_path)
    assert "Not known: " in text
    assert "pin.radius" in text


def test_facts_of_a_page_are_those_of_its_sweep():
    held = content(synthetic.sweep())
    ends = "200 to 750 N, 0.5 to 4 m/s"
    assert held["outside"] == f"Type a load and a velocity within the sweep: {ends}."
    assert held["friction_band"] == (0.09, 0.103)
    assert held["surfaces"] is None
    assert (held["loads"][-1], held["velocities"][0]) == (750.0, 0.5)
    by_label = {one["label"]: one for one in held["numbers"]}

    def values(label):
        return np.frombuffer(base64.b64decode(by_label[label]["values"]), "<f4").reshape(12, 15)

    # At 750 N and 4 m/s, by the closed forms of the sweep.
    time = 750.0 / synthetic.RATE
    for label, unit, value in (
        ("contact width", "µm", 9.0 * 750**0.5 * 1.8),
        ("contact area", "% of the window", 1.2 * 750**0.5),
        ("mean pressure", "GPa", 0.04 * 750**0.5),
        ("highest pressure", "GPa", 6.6),
        ("contact at the hardness", "%", 2.0 + 0.01 * 750),
        ("wear depth", "µm", 2e-3 * 4.0 * 750**0.9),
        ("worn volume", "mm³", 1.2e-6 * 0.5 * synthetic.RATE * time**2 * 4.0),
        ("pin’s share of the heat", "%", 40.0),
        ("sliding distance", "m", 4.0 * time),
        ("duration", "s", time),
    ):
        assert by_label[label]["unit"] == unit
        assert values(label)[-1, -1] == pytest.approx(value, rel=1e-6), label
    marked = synthetic.sweep(status={(200.0, 0.5): 2, (250.0, 1.0): 0})
    marked["message"][3, 2] = "careful"
    held = content(marked)
    assert held["messages"] == {"0": "out of memory", str(3 * 15 + 2): "careful"}
    assert json.dumps(held, allow_nan=False)


@pytest.mark.parametrize(
    ("make", "names", "disk"),
    [
        (sweeps.one, ["friction", "bulk_temperature", "critical_temperature", "failing_share"],
         None),
        (lambda: sweeps.one(conditions=replace(OWN, criterion="mean")),
         ["friction", "bulk_temperature", "critical_temperature"], None),
        (sweeps.of_a_warm_pin,
         ["friction", "bulk_temperature", "disk_temperature", "critical_temperature"], 298.15),
        (lambda: sweeps.of_two_bulks(disk_temperature=298.15),  # as warm as the pin, so far
         ["friction", "bulk_temperature", "disk_temperature", "critical_temperature",
          "failing_share"], 298.15),
    ],
    ids=["share", "mean", "warm pin", "equal bulks"],
)  # fmt: skip
def test_a_page_lets_conditions_be_changed_that_its_sweep_answers_for(make, names, disk):
    held = content(make(), 0)
    assert [control["name"] for control in held["controls"]] == names
    assert held["conditions"].get("disk_temperature") == disk


def test_without_a_critical_temperature_the_hottest_points_have_their_fields():
    ds = synthetic.sweep(
        [200.0, 400.0], [1.0, 2.0, 4.0], fields=True,
        conditions=replace(OWN, critical_temperature=None),
    )  # fmt: skip
    rises = synthetic.rise(np.array([[200.0], [400.0]]), np.array([1.0, 2.0, 4.0])).ravel()
    hottest = sorted(np.argsort(rises)[-2:].tolist())
    assert sorted(map(int, content(ds, 2)["fields"]["points"])) == hottest


def test_a_page_of_samples_has_the_probability_between_their_ends(monkeypatch, tmp_path):
    samples.fewer_draws(monkeypatch)
    test = {"normal_load": 400.0, "velocity": 2.0, "friction": None}
    ds = samples.dataset(samples.ensemble(tests=[test]))
    page = pipeline.explore(ds, tmp_path / "page.html")
    text = page.path.read_text(encoding="utf-8")
    held = json.loads(re.findall(r'id="content">(.*?)</script>', text, re.DOTALL)[0])
    (field,) = fields(ds)
    ensemble, scatter = field.ensemble, model_error(ds, field)
    loads, velocities = np.array(held["loads"]), np.array(held["velocities"])
    assert (loads[0], loads[-1]) == (ensemble.loads[0], ensemble.loads[-1]) == (200.0, 750.0)
    assert (velocities[0], velocities[-1]) == tuple(ensemble.velocities)
    plane = floats(held["probability"]).reshape(len(loads), len(velocities))
    middle = len(loads) // 2
    expected = field.probability(loads[middle], velocities, scatter)
    np.testing.assert_allclose(plane[middle], expected, atol=1e-6)
    # Loads rise upwards: the picture's top row is that of the highest one.
    picture = opened(held["picture"])
    assert picture.size == (len(velocities), len(loads))
    assert coloured(plane[::-1]) == held["picture"]
    scale = opened(re.findall(r'href="data:image/png;base64,([^"]*)"', text)[-1]).convert("RGB")
    blue, red = scale.getpixel((0, 0)), scale.getpixel((scale.width - 1, 0))
    assert blue[2] > blue[0]
    assert red[0] > red[2]
    assert held["misfit"] == []
    assert len(held["measured"]) == 1
    assert f"he model's own error: {scatter.worded}" in unescape(text)
    assert (page.points, page.points_with_fields) == (int((ds["status"] == DONE).sum()), 0)
    assert "<th>friction</th>" not in text  # each sample has its own


def test_tests_have_their_nearest_node_and_lie_inside_or_not():
    ds = with_fields(
        synthetic.sweep(),
        measured=synthetic.MEASURED[:1],
        tested=(
            replace(synthetic.MEASURED[3], normal_load=150.0, outcome="mild"),
            replace(synthetic.MEASURED[3], outcome="severe"),
        ),
    )
    held = content(ds)
    first, mild, lowest = held["measured"]
    for test in (first, mild, lowest):
        k, j = test["node"]
        loads, velocities = (np.array(held["fine"][name]) for name in ("load", "velocity"))
        inner = velocities[held["first"] : held["first"] + len(held["inner"])]
        assert abs(loads - test["load"]).argmin() == k
        assert abs(inner - test["velocity"]).argmin() == j - held["first"]
    inside = [test["isInside"] for test in (first, mild, lowest)]
    assert inside == [True, False, True]  # at 750, 150 and 200 N
    assert first["own"]["friction"] == 0.103
    assert (first["own"]["strip_friction"], mild["own"]["strip_friction"]) == (True, False)


# Nodes


@pytest.mark.parametrize(
    ("loads", "velocities", "others", "pieces"),
    [
        (4, 7, 1, (10, 10)),
        (11, 61, 1, (1, 3)),
        (8, 14, 1, (5, 5)),  # not evenly: more places, never fewer
        (31, 16, 1, (4, 1)),
        (32, 62, 1, (1, 1)),
        (1, 2, 1, (60, 30)),
        (31, 61, 10**6, (1, 1)),
        (4, 7, 400, (7, 7)),  # 43 · 22 values of 400 are 378 000, and one part more is too many
    ],
)
def test_planes_are_divided_into_60_by_30_places_where_there_is_room(
    loads, velocities, others, pieces
):
    assert pieces_of(loads, velocities, others) == pieces


def test_places_are_divided_evenly_between_points():
    assert divided(np.array([1.0, 2.0, 4.0]), 2).tolist() == [1.0, 1.5, 2.0, 3.0, 4.0]
    assert divided(np.array([1.0]), 3).tolist() == [1.0]


def test_power_laws_are_kept_between_points_and_beyond():
    x = np.array([1.0, 2.0, 4.0])
    places = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0])
    values = np.column_stack([x**0.7, 5 * x**0.5])
    fine = along(values, x, places, 0, continued=True)
    np.testing.assert_allclose(fine, np.column_stack([places**0.7, 5 * places**0.5]), rtol=1e-9)
    inner = along(values, x, places, 0)
    assert np.isnan(inner[[0, -1]]).all()
    np.testing.assert_allclose(inner[1:-1], fine[1:-1], rtol=1e-9)
    np.testing.assert_array_equal(along(values[:1], x[:1], places, 0), values[:1])
    negative = along(-values.T, x, x, 1)
    np.testing.assert_allclose(negative, -values.T)


def test_nodes_are_computed_interpolated_beyond_one_row_or_beyond_both():
    """Two loads of four velocities; at the second one only the middle two are done."""
    done = np.array([[True, True, True, True], [False, True, True, False]])
    places = np.arange(-1, 8)  # two parts of each interval of velocities, one before, one after
    state = states(done, (2, 2), places)
    assert state[0].tolist() == [4, 1, 2, 1, 2, 1, 2, 1, 4]
    assert state[1].tolist() == [4, 3, 3, 2, 2, 2, 3, 3, 4]
    assert state[2].tolist() == [4, 4, 4, 1, 2, 1, 4, 4, 4]
    several = states(np.stack([done[::-1], done, done]), (2, 2), places)
    assert several.tolist() == [state[::-1].tolist(), state.tolist(), state.tolist()]
    nothing = states(np.array([[True, True], [False, False]]), (2, 1), np.arange(2))
    assert nothing.tolist() == [[1, 1], [4, 4], [4, 4]]


def test_codes_and_arrays_are_written_as_they_are_read():
    assert digit_string(np.array([[1, 0], [4, np.nan]])) == "1040"
    assert digit_string([True, False]) == "10"
    assert np.frombuffer(base64.b64decode(packed_array([1.5, -2], "<f4")), "<f4").tolist() == [
        1.5, -2.0
    ]  # fmt: skip


# Pictures


def opened(text):
    return Image.open(io.BytesIO(base64.b64decode(text)))


def levels(text):
    """Levels of a picture by x and y."""
    return np.array(opened(text)).T[:, ::-1]


def test_pictures_have_levels_from_the_lowest_to_the_highest():
    pressure = np.array([[0.0, 1e9], [2e9, 4e9]])
    rise = np.array([[9e3, 100.0], [200.0, 300.0]])  # what is not in contact does not count
    depth = np.array([[0.0, 1e-6], [2e-6, 4e-6]])
    highest, low, high, deepest, p, warm, worn = packed_point(pressure, rise, depth)
    assert (highest, low, high, deepest) == (4e9, 100.0, 300.0, 4e-6)
    assert levels(p).tolist() == levels(worn).tolist() == [[0, 64], [128, 255]]
    assert levels(warm).tolist() == [[0, 1], [128, 255]]


def test_blocks_of_many_elements_are_averaged_and_the_last_one_may_be_shorter():
    pressure = np.zeros((241, 3))  # blocks of 3
    pressure[0, 0], pressure[240, 2] = 3e9, 6e9
    rise = np.where(pressure > 0, 500.0, 0.0)
    rise[1, 0], pressure[1, 0] = 700.0, 1e-3
    highest, low, high, _, p, *_ = packed_point(pressure, rise, 0 * pressure)
    assert levels(p).shape == (81, 3)
    assert highest == pytest.approx(6e9)  # alone in its block
    assert (low, high) == (500.0, 600.0)  # the mean of 500 and 700 K
    nothing = packed_point(0 * pressure, rise, 0 * pressure)
    assert nothing[:4] == [0.0, 0.0, 0.0, 0.0]
    assert not levels(nothing[5]).any()


def test_the_note_of_pictures_says_their_window_and_what_was_averaged():
    ds = synthetic.sweep([200.0], [1.0, 2.0], fields=True)
    held = packed_fields(ds, [(0, 1)], 0.0)
    assert held["note"] == (
        "384 × 432 µm; sliding to the right. The temperature is that of the parts in contact."
    )
    assert held["aspect"] == pytest.approx(384 / 432)
    assert [*held["points"]] == ["1"]
    assert held["points"]["1"][0] == pytest.approx(float(ds["pressure"][0, 1].max()))
    one = packed_fields(ds.isel(y=[3]), [(0, 1)], 0.0)
    assert one["note"].startswith("384 µm along sliding; sliding to the right.")
    assert one["aspect"] == 8.0
    narrow, wide = (
        packed_fields(ds.assign_coords({axis: 10 * ds[axis]}), [(0, 0)], 0.0)["aspect"]
        for axis in ("y", "x")
    )
    assert (narrow, wide) == (0.4, 8.0)
    fine = ds.isel(x=np.arange(240) % 48).assign_coords(x=np.arange(240) * 8e-6)
    assert ", averaged over 2 × 1 elements." in packed_fields(fine, [(0, 0)], 0.0)["note"]
    assert [opened(scale).size for scale in held["scales"]] == [(255, 1)] * 3


@pytest.mark.parametrize("ratio", [20.0, -20.0])
def test_rises_are_above_the_colder_body(ratio):
    ds = synthetic.sweep([200.0], [1.0], fields=True)
    ds["bulk_response"] = 0.5 + 0 * ds["rise"]
    plain, warm = (packed_fields(ds, [(0, 0)], at)["points"]["0"] for at in (0.0, ratio))
    more = 0.5 * ratio + max(0.0, -ratio)
    assert warm[1:3] == pytest.approx([plain[1] + more, plain[2] + more])


def test_probabilities_are_pale_at_their_ends_and_severe_wear_is_red():
    image = opened(coloured(np.array([[0.0, 0.5, 1.0]]))).convert("RGB")
    assert image.size == (3, 1)
    mild, even, severe = (image.getpixel((k, 0)) for k in range(3))
    assert mild[2] > mild[0] + 50
    assert severe[0] > severe[2] + 50
    assert min(even) > 150


# Planes

SPARSE = ((200.0, 400.0, 600.0), (1.0, 2.0, 4.0))


def floats(text):
    return np.frombuffer(base64.b64decode(text), "<f4")


def sparse(**told):
    loads, velocities = SPARSE
    return synthetic.sweep(loads=loads, velocities=velocities, **told)


@pytest.fixture(scope="module")
def missing():
    """Three loads of three velocities, without the fastest point at the highest load."""
    ds = sparse(status={(600.0, 4.0): 0})
    return ds, content(ds)


def test_a_plane_has_the_closed_form_between_the_points_and_far_beyond_them():
    held = content(sparse())
    loads, velocities = (np.array(held["fine"][axis]) for axis in ("load", "velocity"))
    assert (loads[0], loads[-1], len(loads)) == (200.0, 600.0, 31)
    assert (velocities[0], velocities[-1], len(velocities)) == (1e-6, 4e6, 63)
    shares = np.array(held["shares"])
    assert {0.0, 0.1, 0.5, 1.0} <= {float(round(share, 9)) for share in shares}
    plane = floats(held["plane"]).reshape(31, 63, len(shares))
    expected = synthetic.rise(loads[:, None, None], velocities[:, None], 1 - shares)
    np.testing.assert_allclose(plane, expected, rtol=1e-5)
    assert held["columns"] == {}
    assert held["missing"] == [0]
    assert held["friction_factors"] == [1.0] * 63
    assert held["friction_by_temperature"] == [(0.0,), (1.0,)]


def test_nodes_of_a_plane_know_the_points_and_rows_that_they_lie_at_or_between():
    held = content(sparse())
    loads, velocities = (held["fine"][axis] for axis in ("load", "velocity"))
    at = held["nodes"]
    assert [loads[k] for k in at["load"]] == [*SPARSE[0]]
    assert [velocities[j] for j in at["velocity"]] == [*SPARSE[1]]
    assert held["first"] == 1
    assert (held["inner"][0], held["inner"][-1], len(held["inner"])) == (1.0, 4.0, 61)
    for k, (below, above) in enumerate(held["beside"]):
        assert below <= k <= above
        assert {below, above} <= {*at["load"]}
        assert (above - below) == (0 if k in at["load"] else 15)
    rest = content(synthetic.sweep(loads=SPARSE[0], velocities=(0.0, 1.0, 2.0)))
    assert (rest["first"], rest["inner"][0], rest["inner"][-1]) == (1, 1.0, 2.0)
    one = content(synthetic.sweep(loads=SPARSE[0], velocities=(2.0,)))
    assert (one["first"], one["fine"]["velocity"], one["inner"]) == (0, [2.0], [2.0])


def test_a_line_at_a_velocity_has_its_own_points_alone_where_one_is_missing(missing):
    _, held = missing
    loads, velocities = (np.array(held["fine"][axis]) for axis in ("load", "velocity"))
    (node,) = (int(np.flatnonzero(velocities == 4.0)[0]),)
    nodes = loads.size * velocities.size
    assert held["columns"] == {f"0 {node}": nodes}
    assert held["missing"] == [1]
    shares = np.array(held["shares"])
    column = floats(held["plane"]).reshape(-1, len(shares))[nodes:]
    assert column.shape == (31, len(shares))
    inner = loads <= 400.0
    expected = synthetic.rise(loads[inner, None], 4.0, 1 - shares)
    np.testing.assert_allclose(column[inner], expected, rtol=1e-5)
    assert np.isnan(column[~inner]).all()
    state = np.array([*map(int, held["state"])])
    assert state[nodes:].tolist() == [2 if within else 4 for within in inner]
    plane = state[:nodes].reshape(31, 63)
    assert plane[-1, node] == 4
    assert (plane == 1).sum() == 8
    assert {*plane[:, 0]} == {*plane[:, -1]} == {4}
    assert plane[20, node] == 3  # between a row that is done there and one that is not


def test_of_several_surfaces_each_has_a_line_where_its_own_points_are_missing(missing):
    ds, alone = missing
    both = xr.concat([sparse(), ds], xr.Variable("realization", [3, 4]), combine_attrs="override")
    held = content(both)
    shares, nodes = len(held["shares"]), len(alone["state"]) - 31
    ((name, _),) = alone["columns"].items()
    assert held["columns"] == {name.replace("0 ", "1 "): 2 * nodes}
    assert held["missing"] == [0, 1]
    own, plane = (floats(one["plane"]).reshape(-1, shares) for one in (alone, held))
    np.testing.assert_array_equal(plane[2 * nodes :], own[nodes:])  # the line
    np.testing.assert_array_equal(plane[nodes : 2 * nodes], own[:nodes])
    assert held["state"][nodes:] == alone["state"]


def test_the_error_at_a_node_is_that_of_a_margin_there(missing):
    ds, held = missing
    loads, velocities = (held["fine"][axis] for axis in ("load", "velocity"))
    errors = floats(held["errors"]).reshape(31, 63)
    for k, j in ((0, 1), (15, 31), (7, 31), (15, 20), (22, 40), (22, 55), (30, 61), (15, 0)):
        there = pipeline.margin(ds, loads[k], velocities[j]) if 1 <= j <= 61 else None
        if there is None:
            assert errors[k, j] > errors[k, 1]  # it grows with the way from the last point
            continue
        relative = there.temperature_error / (there.decisive_temperature - 298.15)
        assert errors[k, j] == pytest.approx(relative, rel=1e-5), (k, j)


def test_the_model_s_error_is_told_by_the_number_of_tests():
    held = content(sparse(measured=synthetic.MEASURED[:2]))["model"]
    assert len(held["below"]) == len(held["words"]) == 3
    distances, below = np.array(held["distances"]), np.array(held["below"])
    assert (distances[0], distances[-1]) == pytest.approx((-np.sinh(7.0), np.sinh(7.0)))
    assert distances[120] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(below[:, 120], 0.5)
    np.testing.assert_allclose(below + below[:, ::-1], 1.0, atol=1e-6)
    assert (held["prior"], held["worth"]) == (0.1, 4)
    assert held["words"][0] == ModelError().worded


def test_fields_of_several_scenes_share_the_most_that_a_page_holds(tmp_path):
    with pytest.raises(InputError, match="most_fields is -1; it must be at least 0"):
        pipeline.explore(sparse(), tmp_path / "a.html", most_fields=-1)
    none = pipeline.explore(sparse(), tmp_path / "a.html", most_fields=0)
    assert (none.points, none.points_with_fields) == (9, 0)
    held = pipeline.explore(sparse(fields=True), tmp_path / "b.html", most_fields=4)
    assert (held.points, held.points_with_fields) == (9, 4)
    assert held.path == tmp_path / "b.html"
    radii = (1e-3, 2e-3)
    two = xr.concat(
        [sparse(fields=True, variants=two_pins()) for _ in radii],
        xr.DataArray([*radii], dims="pin.radius", name="pin.radius", attrs={"units": "m"}),
        combine_attrs="override",
    )
    both = pipeline.explore(two, tmp_path / "c.html", most_fields=5)
    assert (both.points, both.points_with_fields) == (18, 4)
