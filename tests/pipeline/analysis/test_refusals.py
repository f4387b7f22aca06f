"""All refusals of answers: what causes each, and what its message says."""

from functools import cache
from pathlib import Path

import xarray as xr

import pipeline
from pipeline import Conditions
from pipeline.analysis.rises import rises_of
from pipeline.analysis.tables import writable_path, write_text
from pipeline.store.create import writing
from tests.helpers import synthetic, tiny
from tests.helpers.entries import placed_rows, rows
from tests.helpers.refusals import refusal_tests
from tests.helpers.sweeps import with_fields
from tribo import Motion

plane = cache(synthetic.sweep)


def made(friction=0.1, **values):
    """Dataset of a new store without any point."""
    path = Path(f"some_{len([*Path().glob('some_*')])}.zarr")
    conditions = Conditions(friction, 298.15, 418.15)
    with writing(path, tiny.sweep(conditions=conditions, **values)):
        pass
    return pipeline.open_sweep(path)


def places():
    return made(variants=placed_rows((250.0, 1.0)))


def joined(sweeps, dim="load"):
    return xr.concat(
        sweeps, dim, data_vars="all", coords="different", compat="equals", join="outer"
    )


def fast():
    velocities = plane()["velocity"] * 3.6
    return plane().assign_coords(velocity=velocities.assign_attrs(units="km/h"))


def pins():
    return made(variants=rows("pin", {"a": {}, "b": {"pin.radius": 6e-3}}))


def frictions():
    ds = plane()
    return ds.assign_coords({"friction_coefficient": ("load", 0.1 + 0 * ds["load"].values)})


def at(**values):
    return lambda: pipeline.at(plane(), **values)


def margin(*place, **values):
    return lambda: pipeline.margin(synthetic.sweep(**values), *place)


def unmoved():
    conditions = Conditions(0.0, 298.15, 418.15)
    rolling = with_fields(plane(), motion=Motion(entrainment_velocity=2.0), conditions=conditions)
    return pipeline.at(with_fields(rolling, friction_band=None), friction=0.1)


def taken():
    Path("a.csv").mkdir()
    return writable_path("a.csv", (".csv",))


def unwritable():
    Path("a.csv").mkdir()
    return write_text("", Path("a.csv"))


def unknown_place():
    """Ask a field for the temperature beyond its loads."""
    return rises_of(pipeline.results(plane())).known(9e3, 1.0).require()


REFUSALS = {
    # other conditions
    "entry": (at(**{"pin.radius": "3 mm"}), "; run the scene with pin.radius = 3 mm into"),
    "condition": (at(friktion=0.1), 'friktion is no entry of a scene (did you mean "friction'),
    "misspelt": (at(**{"pin.radus": "3 mm"}), 'pin.radus is no entry of a scene (did you mean'),
    "part": (at(**{"pin.material.hardness": "3 GPa"}), "with pin.material.hardness = 3 GPa into"),
    "read": (lambda: pipeline.boundary(pipeline.results(plane()), friction=0.1),
             "friction cannot be given for results that were read; give the dataset"),
    "no test": (lambda: pipeline.infer(synthetic.sweep(measured=())), "has no test with a result"),
    "twice": (at(friction=0.1, **{"friction.coefficient": 0.2}), "coefficient is given twice"),
    "friction": (at(friction="a lot"), "friction is 'a lot'; give a number"),
    "negative": (at(friction=-0.1), "friction is -0.1; it must be finite and ≥ 0"),
    "own friction": (lambda: pipeline.at(frictions(), friction=(0.1, 0.2)), "one value at a time"),
    "one negative": (at(friction=(0.1, -0.1)), "friction is -0.1; it must be finite and ≥ 0"),
    "value twice": (at(bulk_temperature=("60 degC", 333.15)), "is 333.15 twice; give each"),
    "none": (at(friction=()), "friction has no value"),
    "criteria": (at(criterion=["mean", "highest"]), "criterion takes one value at a time"),
    "criterion": (at(criterion="coldest"), "coldest"),
    "cold": (at(critical_temperature=145.0), "critical_temperature is -128.1 °C (145 K)"),
    "hot": (at(bulk_temperature=1200.0), "(1200 K), at which no oil works"),
    "unit": (at(bulk_temperature="60 N"), "60 N"),
    "share": (at(share=1.5), "1.5"),
    "one body": (at(bulk_temperature={"pin": 300.0}), "bulk_temperature names pin"),
    "bodies": (at(bulk_temperature={"pin": 300.0, "disk": 310.0}), "bodies of one bulk"),
    "label": (lambda: pipeline.at(pins(), pin="c"), "pin is c, which the sweep does not have"),
    "at": (lambda: pipeline.boundary(plane().assign_attrs(at="hotter")), "`at` is 'hotter'"),
    "no end": (lambda: pipeline.boundary(plane().isel(step=[0])), "lacks step 0, the end"),
    "no heat": (unmoved, "the sweep was computed without friction"),
    "surface": (lambda: pipeline.plot(plane(), realization=3), "realization is 3; the sweep has"),
    # datasets
    "variables": (lambda: pipeline.boundary(plane()[["max_rise"]]), "the dataset has no status"),
    "no flags": (lambda: pipeline.margin(plane().drop_vars("warning_flags"), 400.0, 2.0),
                 "the dataset has no warning_flags; take all of its variables"),
    "no sweep": (lambda: pipeline.boundary(plane().drop_attrs()), "has no attribute scene"),
    "dimension": (lambda: pipeline.margin(joined([plane()] * 2, "k"), 400.0, 2.0),
                  "a dimension k, which its sweep does not have; select one of its values"),
    "km/h": (lambda: pipeline.boundary(fast()), "velocity of the dataset is in km/h; convert it"),
    "row": (lambda: pipeline.boundary(pins().isel(pin=0, drop=True)),
            "has lost its coordinate pin"),
    "lost axis": (lambda: pipeline.boundary(
                      plane().assign(status=plane()["status"].isel(load=0, drop=True))),
                  "status of the dataset has lost its axis load"),
    "complex": (lambda: pipeline.boundary(
                    plane().assign(rise_quantile=plane()["rise_quantile"] + 1j)),
                "rise_quantile of the dataset is complex; take its real part"),
    "no dataset": (lambda: pipeline.boundary(plane()["status"]),
                   "a sweep cannot be a DataArray; give a dataset of pipeline.open_sweep"),
    "text": (lambda: pipeline.boundary(
                      plane().assign(rise_quantile=plane()["rise_quantile"].astype(object)
                                     .where(False, "x"))), "rise_quantile of the dataset is no n"),
    "long name": (lambda: writable_path("a" * 300 + ".csv", (".csv",)), "File name too long"),
    "one point": (lambda: pipeline.boundary(plane().isel(load=0, velocity=0)),
                  "the dataset has a single load"),
    "end cut off": (lambda: pipeline.end_of_point(plane().isel(step=[0])), "lacks step 0"),
    "an unknown place": (unknown_place,
        "load is 9000 N; the sweep has 200 to 750 N; this adds it: irg run synthetic.toml --set "),
    "temperatures": (lambda: pipeline.temperatures(plane()[["status", "max_rise"]]),
                     "the dataset has no mean_rise, rise_quantile"),
    "shares": (lambda: pipeline.temperatures(plane().isel(cooler_share=[0])),
               "the dataset has 1 of 30 shares"),
    "no plane": (lambda: pipeline.boundary(places()), "so there is no plane"),
    "renamed": (lambda: pipeline.boundary(plane().rename(load="F")), "the dataset has no load;"),
    "emptied": (lambda: pipeline.boundary(plane().isel(velocity=[])), "has no velocity left"),
    "no number": (lambda: pipeline.boundary(plane().assign_coords(load=[*range(11), float("nan")])),
                  "a load that is no finite number"),
    "no shares": (lambda: pipeline.boundary(plane().drop_vars("cooler_share")), "no axis cooler"),
    "doubled": (lambda: pipeline.boundary(plane().isel(load=[0, 1, 1])), "has a load twice"),
    # places
    "load": (margin(900.0, 2.0), "load is 900 N; the sweep has 200 to 750 N"),
    "velocity": (margin(400.0, 0.1), "velocity is 0.1 m/s; the sweep has 0.5 to 4 m/s"),
    "nothing": (margin(400.0, 2.1, status=synthetic.NOTHING),
                "too few points about 400 N and 2.1 m/s"),
    "no load": (margin(None, 2.0), "load and velocity go together; give both"),
    "no velocity beside text": (margin("400 N"), "load and velocity go together; give both"),
    "no velocity": (margin(400.0), "load and velocity go together; give both"),
    "no place": (margin(), "no operating point is given"),
    "loads": (margin([400.0], 2.0), "not 'list'; give one such as \"500 N\""),
    # files
    "suffix": (lambda: writable_path("a.txt", (".csv", ".xlsx")), "must be one of .csv, .xlsx"),
    "folder": (lambda: writable_path("no/a.csv", (".csv",)), "there is no folder no"),
    "taken": (taken, "it is a folder"),
    "unwritable": (unwritable, "cannot write a.csv: Is a directory"),
}  # fmt: skip


ELSEWHERE = {
    "margin_frame.margin InputError": "test_at.py",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "analysis", REFUSALS, ELSEWHERE
)
