"""What a user reads, in text and JSON, is what Python gives, for a store of each kind."""

import functools
import re

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.constants import PRESET_BOUNDS
from pipeline.store.schema import DONE, FAILED, PENDING
from pipeline.sweep.plan import points
from tests.helpers import stores as helpers
from tests.helpers.answer_at import named
from tests.helpers.scenes import MEASURED
from tests.helpers.scenes import SCENE as SMALL
from tests.pipeline.conftest import commit_all

ERROR = PRESET_BOUNDS["standard"]
AXES = (
    'loads = ["200 N", "400 N", "600 N"]\nvelocities = ["1 m/s", "2 m/s", "4 m/s"]\nfields = true'
)
FEWER = 'loads = ["400 N", "600 N"]\nvelocities = ["2 m/s", "4 m/s"]\n'
MILD = """
[[tests]]
load = "400 N"
velocity = "1 m/s"
outcome = "mild"
"""
TESTED = f"""{MILD}
[[tests]]
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


@functools.cache
def opened(store):
    """Dataset of a store as plain xarray reads it, loaded once."""
    with xr.open_zarr(store, chunks=None) as ds:
        return ds.load()


@pytest.mark.parametrize("kind", ["broken", "surfaces", "rows"])
def test_status_and_verify_count_the_points_of_the_dataset(irg, stores, kind):
    ds = opened(stores(kind))
    counts = {flag: int((ds["status"] == flag).sum()) for flag in (DONE, FAILED, PENDING)}
    code = 1 if counts[FAILED] else 0
    (record,) = irg("status", stores(kind), "--json", code=code)
    said = irg("status", stores(kind), code=code)
    assert record["title"] == "A small sweep"
    assert (record["points"], record["done"]) == (ds["status"].size, counts[DONE])
    assert (record["pending"], record["failed"]) == (counts[PENDING], counts[FAILED])
    line = "{} points: {} done, {} failed, {} pending"
    assert line.format(ds["status"].size, counts[DONE], counts[FAILED], counts[PENDING]) in said
    assert said.count(": out of memory\n") == said.count("failed: ") == counts[FAILED]
    assert f"of critical velocities at most {100 * ERROR:g} %" in said
    flags = ds["warning_flags"].where(ds["status"] == DONE, 0).values.astype(int)
    if count := np.count_nonzero(flags):
        by_bit = [np.count_nonzero(flags & bit) for bit in 1 << np.arange(31)]
        (kinds,) = re.findall(r"a warning \((.*?)\)", " ".join(said.split()))
        found = sorted(int(number) for number in re.findall(r": (\d+)", kinds))
        assert found == sorted(filter(None, by_bit))
        assert f"{count} point{' carries' if count == 1 else 's carry'}" in said
    checked = irg("verify", stores(kind), "--json")
    assert checked["points"] == {"done": counts[DONE], "damaged": 0}
    assert (checked["damaged"], checked["shared"]) == ([], [])
    assert f"points: {counts[DONE]} done and undamaged, 0 damaged" in irg("verify", stores(kind))


def place_of(load, velocity):
    return "--load", f"{load} N", "--velocity", f"{velocity} m/s"


def test_a_point_alone_is_the_point_of_the_store(stores, irg_both):
    ds = opened(stores("plane")).sel(load=400, velocity=4, step=0)
    words = ("point", stores("plane").with_suffix(".toml"), *place_of(400, 4))
    said, (row,) = irg_both(*words)
    quantiles, highest = ds["rise_quantile"], 298.15 + 0.1 * ds["max_rise"].item()
    temperature = 298.15 + 0.1 * quantiles.sel(area_fraction_below=0.9).item()
    assert row["governing temperature [°C]"] == pytest.approx(temperature - 273.15, rel=1e-9)
    assert row["temperature margin [K]"] == pytest.approx(418.15 - temperature, rel=1e-9)
    assert f"governing temperature   {temperature - 273.15:.4g} °C, simulated at this point" in said
    for words, value in {
        "highest temperature [°C]": highest - 273.15,
        "heat into the pin [%]": 100 * ds["pin_heat_share"].item(),
        "contact width [µm]": 1e6 * ds["contact_width"].item(),
        "real contact area of the window [%]": 100 * ds["contact_fraction"].item(),
        "mean pressure [GPa]": 1e-9 * ds["mean_pressure"].item(),
        "highest pressure [GPa]": 1e-9 * ds["max_pressure"].item(),
        "wear depth [µm]": 1e6 * ds["wear_depth_max"].item(),
        "wear volume [mm³]": 1e9 * ds["wear_volume"].item(),
        "time [s]": ds["time"].item(),
        "sliding distance [m]": ds["sliding_distance"].item(),
        "failed area fraction [%]": row["failed area fraction [%]"],
    }.items():
        assert row[words] == pytest.approx(value, rel=1e-9)
        assert re.search(rf"^{re.escape(words)} +{re.escape(f'{value:.4g}')}$", said, re.MULTILINE)
    cooler = np.interp(1200.0, quantiles.values, quantiles["area_fraction_below"].values)
    assert row["failed area fraction [%]"] == pytest.approx(100 * (1 - cooler), abs=2)


# The same answer as text, as JSON and in Python

OTHERWISE = (
    ("--friction", "0.12", "--bulk-temperature", "60 degC", "--critical-temperature", "170 degC"),
    {"friction": 0.12, "bulk_temperature": "60 degC", "critical_temperature": "170 degC"},
)
HEADS = {"critical_velocity_p50": "with tests, 50 %", "critical_velocity_p05": "5 %"}
ASKED = {
    "broken": ("broken", (), {}, {}),
    "surfaces": ("surfaces", (), {}, {}),
    "plane": ("plane", *OTHERWISE, {}),
    "over": ("over", ("--at", "pin.radius=4 mm"), {}, {"pin_radius": 4e-3}),
    "frictions": (
        "plane", ("--friction", 0.09, "--friction", 0.103), {"friction": [0.09, 0.103]}, {},
    ),
}  # fmt: skip


def assert_shown(said, values):
    """Each value stands in the text with 4 digits, in its unit there."""
    tokens = set(re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]\d+)?", said))
    for value in np.ravel(values):
        assert not np.isfinite(value) or f"{value:.4g}" in tokens, (value, said)


def assert_rows(rows, found, factors):
    """Rows of JSON have the values of a dataset's variables, times `factors`, minus offsets."""
    for name, (head, factor, offset) in factors.items():
        values = factor * found[name].values.ravel() - offset
        printed = np.array([row[head] for row in rows], float)
        np.testing.assert_allclose(printed, values, rtol=1e-12, err_msg=name)


@pytest.mark.parametrize("case", ASKED)
def test_a_margin_is_the_same_as_text_as_json_and_in_python(irg, stores, case):
    kind, options, conditions, values = ASKED[case]
    ds = pipeline.open_sweep(stores(kind)).sel(values)
    words = "margin", stores(kind), *place_of(500, 2.5), *options
    rows, said = irg(*words, "--json"), irg(*words).replace("\n    ", " ")
    found = pipeline.margin(ds, "500 N", "2.5 m/s", **conditions)
    assert [row["verdict"] for row in rows] == named(found["verdict"]).ravel().tolist()
    of_rows = {
        "probability": ("probability", 1, 0),
        "governing_temperature": ("governing temperature [°C]", 1, 273.15),
        "temperature_margin": ("temperature margin [K]", 1, 0),
        "critical_velocity": ("critical velocity [m/s]", 1, 0),
    }
    assert_rows(rows, found, of_rows)
    assert_shown(said, found["governing_temperature"].values - 273.15)
    assert_shown(said, [found[f"critical_{axis}"].values for axis in ("velocity", "load")])


@pytest.mark.parametrize("case", ASKED)
def test_a_boundary_is_the_same_as_text_as_json_and_in_python(irg, stores, case):
    kind, options, conditions, values = ASKED[case]
    found = pipeline.boundary(pipeline.open_sweep(stores(kind)).sel(values), **conditions)
    for by, names in (
        ("load", ("critical_velocity", "critical_velocity_p50", "critical_velocity_p05")),
        ("velocity", ("critical_load",)),
    ):
        words = "boundary", stores(kind), *options, f"--by={by}", "--all"
        rows, said = irg(*words, "--json"), irg(*words)
        for name in names:
            unit = found[name].attrs["units"]
            text = HEADS.get(name, name.replace("_", " "))
            head = f"{text} [{unit}]"
            printed = np.array([row[head] for row in rows], float)
            wanted = found[name].transpose(..., by).values.ravel()
            np.testing.assert_allclose(printed, wanted, rtol=1e-12, err_msg=name)
            assert_shown(said, wanted)
