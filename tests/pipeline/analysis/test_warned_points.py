"""Points that carry a warning are counted."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import zarr

import pipeline
from pipeline import results, warned
from pipeline.analysis.warned_points import warning_flags
from pipeline.cli import main
from pipeline.sweep.sweep import Point
from tests.helpers import synthetic, tiny
from tests.helpers.stores import fail
from tests.helpers.sweeps import deciding_rise
from tests.pipeline.conftest import commit_all
from tribo import WarningKind

EDGE, WEAR = int(WarningKind.CONTACT_AT_EDGE), int(WarningKind.UNSTABLE_WEAR)


def with_flags(flags, **options):
    """Synthetic sweep with warning flags at some points (load, velocity)."""
    ds = synthetic.sweep(**options)
    values = np.zeros((ds.sizes["load"], ds.sizes["velocity"]), np.int32)
    messages = np.full(values.shape, "", dtype=object)
    for (load, velocity), flag in flags.items():
        place = list(ds["load"].values).index(load), list(ds["velocity"].values).index(velocity)
        values[place], messages[place] = flag, f"flags {flag}"
    dims = ("load", "velocity")
    return ds.assign(warning_flags=(dims, values), message=(dims, messages))


def test_points_are_counted_by_the_kinds_of_their_warnings():
    flags = {(400.0, 2.0): EDGE | WEAR, (400.0, 2.25): EDGE, (200.0, 0.5): EDGE}
    warnings = warned(with_flags(flags))
    assert warnings.points == 3
    assert warnings.kinds == {"unstable wear": 1, "contact at edge": 3}
    assert warnings.example == "200 N, 0.5 m/s: flags 2"
    said = "\n".join(warnings.lines())
    assert "3 points carry a warning (unstable wear: 1, contact at edge: 3)" in said


def test_a_point_is_counted_once_for_several_frictions():
    assert warned(pipeline.at(with_flags({(400.0, 2.0): EDGE}), friction=[0.05, 0.1])).points == 1


COOL = replace(tiny.sweep().conditions, critical_temperature=330.0)


@pytest.fixture(scope="module")
def narrow(tmp_path_factory):
    """Store with warnings: narrow window at the highest load, too old heat at the lower ones."""
    path = tmp_path_factory.mktemp("narrow") / "out.zarr"
    commit_all(path, tiny.sweep(conditions=COOL, increments=12))
    return path


def test_a_summary_counts_the_same_points(narrow, tmp_path):
    path = shutil.copytree(narrow, tmp_path / "out.zarr")
    ds = pipeline.open_sweep(path)
    there = ds["status"].copy(data=warning_flags(results(ds)) != 0)
    count = int(there.sum())
    assert pipeline.summary(path).warned == count > 0
    row, column = np.argwhere(there.values)[0]
    load, velocity = float(ds["load"][row]), float(ds["velocity"][column])
    sweep = tiny.sweep(conditions=COOL, increments=12)
    fail(path, sweep, Point(load, velocity), "it did not converge")
    assert pipeline.summary(path).warned == count - 1
    zarr.open_array(path / "warning_flags", mode="r+")[:] = 0
    assert pipeline.summary(path).warned == 0


def printed(capsys, *arguments):
    main(list(map(str, arguments)))
    return capsys.readouterr().out


def test_every_command_on_a_store_tells(narrow, tmp_path, capsys):
    warnings = warned(pipeline.open_sweep(narrow))
    kinds = ", ".join(f"{kind}: {count}" for kind, count in warnings.kinds.items())
    assert "contact at edge" in kinds
    for command in (["status"], ["boundary"], ["plot", "--kind", "ramp", "-o", tmp_path / "a.png"]):
        text = " ".join(printed(capsys, *command, narrow).split())
        assert f"{warnings.points} points carry a warning ({kinds})" in text
        assert warnings.example in text


def test_points_hotter_than_molten_steel_are_counted(tmp_path, irg):
    commit_all(tmp_path / "tiny.zarr", tiny.full())
    ds = pipeline.open_sweep(tmp_path / "tiny.zarr")
    assert "molten" not in pipeline.warned(ds).kinds
    judged = pipeline.results(ds).conditions
    bulk = judged.bulk_temperature
    molten = (1700.0 - bulk) / float(deciding_rise(ds, judged).max())
    assert "molten" not in pipeline.warned(pipeline.at(ds, friction=0.999 * molten)).kinds
    warned = pipeline.warned(pipeline.at(ds, friction=1.001 * molten))
    assert warned.kinds["molten"] == 1
    both = pipeline.at(ds, friction=[0.1, 1.001 * molten])
    assert pipeline.warned(both).kinds["molten"] == 1
    margin = ("margin", tmp_path / "tiny.zarr", "--load=600 N", "--velocity=1.5 m/s", "--friction")
    assert "where steel melts" in irg(*margin, f"{1.001 * molten:.9g}")
    assert "where steel melts" not in irg(*margin, f"{0.999 * molten:.9g}")
