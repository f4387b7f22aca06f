"""Sweeps made of the fields of all their parts, by name."""

import json

import tribo
from pipeline.answers.results import sweep_of
from pipeline.faults import Faults
from pipeline.scene.build import Files
from pipeline.scene.scene_file import Source
from pipeline.store.schema import INPUTS, split_arrays
from pipeline.sweep.stored import plain_sweep
from tests.helpers.entries import changed

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
    """Sweep with these values of fields of its parts; other fields have usual values."""
    sweep = Source("scene", _BASE, Files()).read(Faults())
    usual = {"fidelity": tribo.Fidelity(), "title": "A scene"}
    return changed(sweep, **usual | values)


def attributes_of(sweep, digests=frozenset()):
    """Dataset attributes of a sweep, as a store has them, without those only for people.

    Arrays of a scene are in the dataset, not in the text; `digests` are those of the dataset.
    """
    plain, arrays = plain_sweep(sweep)
    assert arrays.keys() <= digests, "arrays of a scene lie beside its data"
    return {"title": sweep.title, "sweep": json.dumps(plain)}


def with_fields(ds, **values):
    """Copy of a dataset whose sweep has other values of these fields."""
    digests = split_arrays(ds[INPUTS].values, ds[INPUTS].attrs).keys() if INPUTS in ds else set()
    return ds.assign_attrs(attributes_of(changed(sweep_of(ds), **values), digests))
