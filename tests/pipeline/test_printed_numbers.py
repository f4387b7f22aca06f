"""What a user reads, in text and JSON, is what Python gives, for a store of each kind."""

import functools
import json
import re
from dataclasses import asdict

import numpy as np
import pytest
import xarray as xr
from pipeline.analysis.boundary import boundary_frame
from pipeline.analysis.margin_frame import asked_of
from pipeline.analysis.scenes import attribute_values

import pipeline
from pipeline.answers.tables import records
from pipeline.cli.given import dataset_in
from pipeline.cli.parser import parse
from pipeline.constants import PRESET_BOUNDS
from pipeline.operating_points import OperatingPoints
from pipeline.store.schema import DONE, FAILED, PENDING
from pipeline.sweep.plan import points
from tests.helpers import stores as helpers
from tests.helpers.scenes import MEASURED
from tests.helpers.scenes import SCENE as SMALL
from tests.pipeline.conftest import commit_all

ERROR = PRESET_BOUNDS["standard"]
AXES = (
    'loads = ["200 N", "400 N", "600 N"]\nvelocities = ["1 m/s", "2 m/s", "4 m/s"]\nfields = true'
)
FEWER = 'loads = ["400 N", "600 N"]\nvelocities = ["2 m/s", "4 m/s"]\n'
MILD = """
[[tested]]
load = "400 N"
velocity = "1 m/s"
outcome = "mild"
"""
TESTED = f"""{MILD}
[[tested]]
load = "600 N"
velocity = "3 m/s"
outcome = "mild"
"""
ROW = '{{ "pin.radius" = "{}", "friction.coefficient" = {}, load = "{}", velocity = "{}" }}'
ROWS = ", ".join(
    [ROW.format("2 mm", 0.1, "300 N", "1.5 m/s"), ROW.format("4 mm", 0.12, "500 N", "2 m/s")]
)
SCENE = functools.reduce(
    lambda text, change: text.replace(*change),
    (
        ("increments = 10", ""),
        ("pixels_per_element = 1", 'preset = "standard"'),
        ("[48, 16]", "[48, 24]"),
        ('"16 um"', '"24 um"'),
        ("6.6 GPa", "1 GPa"),  # so that enough elements touch to decide
    ),
    SMALL,
)
CHANGES = {
    "plane": ((AXES, AXES + MEASURED + TESTED),),
    "broken": ((AXES, AXES + MEASURED + TESTED),),
    "surfaces": ((AXES, FEWER + "realizations = 3"),),
    "over": ((AXES, FEWER + 'over = { "pin.radius" = ["2 mm", "4 mm"] }'),),
    "mean": (("failing_share = 0.1", 'criterion = "mean"'), (AXES, FEWER)),
    "rows": ((AXES, f"{FEWER}along = [{ROWS}]"),),
}


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Function that returns the store of a kind, which is made at its first use."""
    folder = tmp_path_factory.mktemp("printed")

    @functools.cache
    def made(kind):
        scene, store = folder / f"{kind}.toml", folder / f"{kind}.zarr"
        text = functools.reduce(lambda text, change: text.replace(*change), CHANGES[kind], SCENE)
        assert all(new in text for _, new in CHANGES[kind])
        scene.write_text(text)
        sweep = pipeline.load_scene(scene)
        # One of nine points fails and one is pending.
        skip = points(sweep)[3:6:2] if kind == "broken" else ()
        with np.errstate(all="raise", under="ignore"):
            commit_all(store, sweep, skip)
        if kind == "broken":
            helpers.fail(store, sweep, skip[0], "out of memory")
        return store

    return made


@pytest.fixture(scope="module")
def answers():
    """Cache of texts and JSON documents of commands."""
    return {}


def margin_in_python(ds, options):
    """Margins of an operating point as plain data, computed in Python."""
    found = [
        *asked_of(
            pipeline.results(ds),
            OperatingPoints(((options.load, options.velocity),), {}),
        )
    ]
    margins = [one.known() for one in found]
    scenes = [as_plain({"verdict": one.verdict} | asdict(one)) for one in margins]
    return {"scenes": scenes} if len(scenes) > 1 else scenes[0]


@pytest.fixture
def ask(stores, answers, irg):
    """Function that runs a command on a store, and returns Python's answer and a check of text."""

    def run(command, kind, *options, code=0):
        asked = (command, kind, *map(str, options))
        if asked not in answers:
            words = command, stores(kind), *options
            whole = [["--all"]] if command == "boundary" else [[]]
            whole += [["--all", "--by=velocity"]] if whole[0] else []
            said = "".join(irg(*words, *more, code=code) for more in whole)
            said = unbroken(said)
            parsed = parse([*map(str, words)])
            document = irg(*words, "--json", code=code)
            if command == "margin":
                said += str([f"{x:.4g}" for row in document for x in row.values() if is_number(x)])
                document = margin_in_python(dataset_in(parsed), parsed)
            answers[asked] = said, json.dumps(document)
        said, document = answers[asked][0], json.loads(answers[asked][1])
        tokens = set(re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]\d+)?", said))

        def shown(*values):
            for value in np.concatenate([np.ravel(as_floats(one)) for one in values]):
                assert not np.isfinite(value) or f"{value:.4g}" in tokens, (value, said)

        return document, said, shown

    return run


@functools.cache
def opened(store):
    """Dataset of a store as plain xarray reads it, loaded once."""
    with xr.open_zarr(store, chunks=None) as ds:
        return ds.load()


def is_number(value):
    return isinstance(value, int | float)


def as_plain(values):
    """Values as in JSON, where those that are not finite are null."""
    if isinstance(values, dict):
        return {name: as_plain(value) for name, value in values.items()}
    if isinstance(values, list | tuple):
        return [as_plain(value) for value in values]
    return None if isinstance(values, float) and not np.isfinite(values) else values


def as_floats(values):
    return np.array(values, dtype=float)  # None is NaN


@pytest.mark.parametrize("kind", ["broken", "surfaces", "rows"])
def test_status_and_verify_count_the_points_of_the_dataset(ask, stores, kind):
    ds = opened(stores(kind))
    counts = {flag: int((ds["status"] == flag).sum()) for flag in (DONE, FAILED, PENDING)}
    code = 1 if counts[2] else 0
    (record,), said, _ = ask("status", kind, code=code)
    assert record["title"] == "A small sweep"
    assert (record["points"], record["done"]) == (ds["status"].size, counts[1])
    assert (record["pending"], record["failed"]) == (counts[PENDING], counts[FAILED])
    line = "{} points: {} done, {} failed, {} pending"
    assert line.format(ds["status"].size, counts[DONE], counts[FAILED], counts[PENDING]) in said
    failed = np.argwhere((ds["status"] == 2).values)
    for index in failed:
        message = pipeline.results(pipeline.open_sweep(stores(kind))).messages[tuple(index)]
        assert f": {message}\n" in said
    assert said.count("failed: ") == len(failed)
    assert f"may be off by up to {100 * ERROR:g} %" in said
    flags = ds["warning_flags"].where(ds["status"] == 1, 0).values.astype(int)
    if count := np.count_nonzero(flags):
        by_bit = [np.count_nonzero(flags & bit) for bit in 1 << np.arange(31)]
        (kinds,) = re.findall(r"a warning \((.*?)\)", " ".join(said.split()))
        found = sorted(int(number) for number in re.findall(r": (\d+)", kinds))
        assert found == sorted(filter(None, by_bit))
        assert f"{count} point{' carries' if count == 1 else 's carry'}" in said
    checked, said, _ = ask("verify", kind)
    assert checked["points"] == {"done": counts[1], "damaged": 0}
    assert (checked["damaged"], checked["shared"]) == ([], [])
    assert f"points: {counts[1]} done and intact, 0 damaged" in said


OTHERWISE = (
    ("--friction", "0.12", "--bulk-temperature", "60 degC", "--critical-temperature", "170 degC"),
    {"friction": 0.12, "bulk_temperature": "60 degC", "critical_temperature": "170 degC"},
)


def unbroken(said):
    """Printed text with wrapped lines joined."""
    return said.replace("\n    ", " ")


def place_of(load, velocity):
    return "--load", f"{load} N", "--velocity", f"{velocity} m/s"


def test_a_point_alone_is_the_point_of_the_store(stores, irg_both):
    ds = opened(stores("plane")).sel(load=400, velocity=4, step=0)
    words = ("point", stores("plane").with_suffix(".toml"), *place_of(400, 4))
    said, (row,) = irg_both(*words)
    quantiles, highest = ds["rise_quantile"], 298.15 + 0.1 * ds["max_rise"].item()
    temperature = 298.15 + 0.1 * quantiles.sel(cooler_share=0.9).item()
    assert row["deciding temperature [°C]"] == pytest.approx(temperature - 273.15, rel=1e-9)
    assert row["distance [K]"] == pytest.approx(418.15 - temperature, rel=1e-9)
    assert f"temperature         {temperature - 273.15:.4g} °C, computed there" in said
    for words, value in {
        "highest temperature [°C]": highest - 273.15,
        "pin's heat share [%]": 100 * ds["pin_heat_share"].item(),
        "contact width [µm]": 1e6 * ds["contact_width"].item(),
        "contact area [%]": 100 * ds["contact_fraction"].item(),
        "mean pressure [GPa]": 1e-9 * ds["mean_pressure"].item(),
        "highest pressure [GPa]": 1e-9 * ds["max_pressure"].item(),
        "wear depth [µm]": 1e6 * ds["wear_depth_max"].item(),
        "wear volume [mm³]": 1e9 * ds["wear_volume"].item(),
        "time [s]": ds["time"].item(),
        "sliding distance [m]": ds["sliding_distance"].item(),
        "failed share [%]": row["failed share [%]"],
    }.items():
        assert row[words] == pytest.approx(value, rel=1e-9)
        assert re.search(rf"^{re.escape(words)} +{re.escape(f'{value:.4g}')}$", said, re.MULTILINE)
    cooler = np.interp(1200.0, quantiles.values, quantiles["cooler_share"].values)
    assert row["failed share [%]"] == pytest.approx(100 * (1 - cooler), abs=2)


# The same answer as text, as JSON and in Python


ASKED = [
    *((kind, (), {}) for kind in ("broken", "surfaces", "mean")),
    ("plane", *OTHERWISE),
    ("over", ("--at", "pin.radius=4 mm"), {"pin.radius": "4 mm"}),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "options", "judged"), ASKED)
def test_a_margin_is_the_same_as_text_as_json_and_in_python(ask, stores, kind, options, judged):
    ds = pipeline.at(stores(kind), **judged)
    document, said, shown = ask("margin", kind, *place_of(500, 2.5), *options)
    margin = pipeline.margin(ds, "500 N", "2.5 m/s")
    plain = as_plain(asdict(margin))
    assert {name: document[name] for name in plain} == plain
    assert next(iter(document)) == "verdict"
    assert said.split("\n")[0] == margin.sentence
    assert f"numerical error     {margin.error.text}" in said
    assert f"model's own error   {margin.model_error}" in said
    (row,) = pipeline.margin(ds, {"load": ["500 N"], "velocity": ["2.5 m/s"]}).to_dict("records")
    for head, value in row.items():
        if isinstance(value, float):
            shown(value)
        elif value:
            lines = value.split(" | ") if head == "notes" else [str(value)]
            is_told = value == "crosses" or head == "verdict"
            assert is_told or all(line in said for line in lines), head
    assert row["probability"] == document["probability"]
    assert row["verdict"] == margin.verdict


@pytest.mark.parametrize(
    ("kind", "options", "judged"),
    [*ASKED[2:], ("plane", ("--friction", 0.09, "--friction", 0.103), {"friction": (0.09, 0.103)})],
)
def test_a_boundary_is_the_same_as_text_as_json_and_in_python(
    ask, irg, stores, kind, options, judged
):
    crossings = pipeline.boundary(pipeline.at(stores(kind), **judged))
    _, said, shown = ask("boundary", kind, *options)
    table = boundary_frame(crossings)
    assert irg("boundary", stores(kind), *options, "--json") == as_plain(records([table]))
    errors = attribute_values(crossings, "model_error")
    assert f"the model's own error: {errors[0]}" in said
    printed = [
        "tested_velocity", "tested_velocity_low", "tested_velocity_high", "critical_velocity",
        "critical_load",
    ]  # fmt: skip
    shown(*(crossings[name].values for name in printed))
