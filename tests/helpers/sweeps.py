"""Sweeps made of the fields of all their parts, by name."""

import numpy as np
import xarray as xr

import pipeline
import tribo
from pipeline.scene.reading import SceneReader
from pipeline.scene.stored_text import file_contents, sweep_text
from pipeline.store.inputs import split_arrays
from pipeline.store.schema import INPUTS, PLANE
from pipeline.sweep.model import Sweep
from tests.helpers.entries import FIELDS, changed

_BASE = {
    "materials": {
        "steel": {
            "elastic_modulus": "210 GPa", "poisson_ratio": 0.3, "hardness": "6.6 GPa",
            "thermal_conductivity": "45 W/(m K)", "density": "7800 kg/m^3",
            "specific_heat": "470 J/(kg K)",
        }
    },
    "pin": {"shape": "ball", "radius": "5 mm", "material": "steel"},
    "disk": {"material": "steel"},
    "window": {"pixels": [8, 8], "pixel_size": ["1 um", "1 um"]},
    "loading": {"rate": "150 N/s", "reference_load": "750 N"},
    "friction": {"coefficient": 0.1},
    "temperature": {"bulk": "25 degC"},
    "sweep": {"loads": ["200 N"], "velocities": ["1 m/s"]},
}  # fmt: skip


def sweep_of_fields(**values):
    """A sweep with these values of the fields of its parts, and the usual ones of the others."""
    assert values.keys() <= FIELDS, values.keys() - FIELDS
    sweep = Sweep(name="scene", written=_BASE, reader=SceneReader())
    usual = {"fidelity": tribo.Fidelity(), "title": "A scene"}
    return changed(sweep, **usual | values)


def attributes_of(sweep, held=frozenset()):
    """Attributes of the dataset of a sweep, as its store has them, but for words for people.

    Arrays of the sweep lie beside its text, in the dataset, which must hold them by these digests.
    """
    assert file_contents(sweep).keys() <= held, "arrays of a scene lie beside its text"
    return {"title": sweep.title, "sweep": sweep_text(sweep)}


def with_fields(ds, **values):
    """The dataset of a sweep with other values of fields of its parts, by their names."""
    held = split_arrays(ds[INPUTS].values, ds[INPUTS].attrs).keys() if INPUTS in ds else set()
    return ds.assign_attrs(attributes_of(changed(pipeline.results(ds).sweep, **values), held))


def decisive_rise(ds, conditions):
    """Rise at friction 1 that decides at each point [K], or NaN, with labels."""
    held = pipeline.results(ds)
    dims = [*held.front, *PLANE]
    coords = {name: ds[name].variable for name in ("realization", *dims) if name in ds.coords}
    return xr.DataArray(held.rises(conditions), coords, dims)


def deciding(ds):
    """Temperature that decides at each point of one scene [K]."""
    judged = pipeline.results(ds).conditions
    return judged.contact_temperature(decisive_rise(ds, judged))


def inputs_of(table):
    """Inputs of the samples of a table by row, shape (n_sample, n_input)."""
    labels = ("sample", "velocity")
    names = [one.name for one in table.coordinates if one.name not in labels]
    return np.array([table.labels(name) for name in names]).T
