"""Reading many points at a time (pipeline/store/soundness.py), and whole arrays of them."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import zarr
from pipeline.store.variables import COLUMNS, FIELDS, RECORDS

from pipeline.run.sweep import run_sweep
from pipeline.store import (
    DONE,
    FAILED,
    PENDING,
    Store,
    compact_store,
    locked,
    prepare,
    sound,
    verify_store,
)
from pipeline.store.identity import checksum, checksums
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points
from tests.helpers import tiny

POINT, LAST = Point(250.0, 1.0), Point(600.0, 1.5)


@pytest.fixture
def copy(alone, tmp_path):
    return shutil.copytree(alone, tmp_path / "copy.zarr")


def chunks(path):
    files = (file for name in (*COLUMNS, *RECORDS, *FIELDS) for file in (path / name).rglob("*"))
    return sorted(file for file in files if file.is_file() and file.suffix != ".json")


def faults(store):
    """What is wrong with each point, looked at alone."""
    found = {}
    for point, flag in store.status().items():
        reason = store.fault(point) if flag == DONE else store.unreadable(point)
        if reason:
            found[point] = reason
    return found


@pytest.mark.parametrize("layout", ["by point", "compact"])
@pytest.mark.parametrize("seed", range(4))
def test_many_at_a_time_are_found_damaged_as_each_alone(copy, layout, seed):
    rng = np.random.default_rng(seed)
    store = Store(copy)
    store.fail(POINT, "not there")  # is done after all
    store.forget(LAST)
    if layout == "compact":
        compact_store(copy)
    for file in rng.permutation(chunks(copy))[: [0, 1, 2, 6][seed]]:
        if rng.integers(2):
            file.unlink()
        else:
            file.write_bytes(file.read_bytes()[:-1])
    store = Store(copy)
    expected = faults(store)
    flags, _ = store.flags()
    found = sound(store, flags, np.ones(flags.shape, bool))
    assert not found[tuple(zip(*map(store.index, expected), strict=True))].any() or not expected
    assert {damage.point: damage.reason for damage in verify_store(copy).damaged} == {
        point: reason if isinstance(reason, str) else f"{', '.join(reason)} cannot be read"
        for point, reason in expected.items()
    }
    if not expected:
        assert found.all()


def test_data_that_were_not_computed_are_found_among_many(copy):
    """Their files can be read, so that no other point is doubted."""
    zarr.open(copy)["max_rise"][0, 1, 0] = 1.0
    zarr.open(copy)["pressure"][2, 1, 0, 0] = 1.0
    store = Store(copy)
    expected = faults(store)
    flags, _ = store.flags()
    found = sound(store, flags, np.ones(flags.shape, bool))
    assert set(expected) == {Point(150.0, 1.0), Point(600.0, 1.0)}
    assert set(store.points_at(np.nonzero(~found))) == set(expected)


def test_only_what_is_asked_for_is_looked_at_and_all_of_it_is_counted(copy):
    store = Store(copy)
    flags, _ = store.flags()
    places = np.zeros(flags.shape, bool)
    places[1:, ::2] = True
    counted = []
    assert np.array_equal(sound(store, flags, places, counted.append), places)
    assert sum(counted) == 4


@pytest.mark.parametrize("layout", ["by point", "compact"])
def test_going_on_looks_at_no_point_alone_where_all_is_well(copy, layout, monkeypatch):
    if layout == "compact":
        compact_store(copy)
    looked = []
    monkeypatch.setattr(Store, "is_intact", lambda self, point: looked.append(point))
    outcome = run_sweep(tiny.full(), copy, workers=1)
    assert (outcome.done, outcome.computed, looked) == (9, 0, [])


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        (None, 7399315487810633093),
        (Point(600.0, 1.5), 8406786481529581124),
        (Point(600.0, 1.5, 3), 2943651491147130702),
        (Point(600.0, 1.5, None, 7), 17240413941857397337),
    ],
)
def test_checksums_are_those_of_earlier_versions(point, expected):
    data = {"time": np.arange(3.0), "rise_quantile": np.arange(6.0).reshape(3, 2)}
    assert checksum(data, point) == expected
    many = {name: np.stack([values, values + 1]) for name, values in data.items()}
    other = checksum({name: values + 1 for name, values in data.items()}, LAST)
    assert checksums(many, [point, LAST]).tolist() == [expected, other]


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"loads": (600.0,), "velocities": (1.0, 1.5)},
        {"chosen": (POINT, LAST)},
        {"chosen": ()},
    ],
)
@pytest.mark.parametrize("realizations", [(), (5, 2)])
def test_places_are_those_of_the_points(tmp_path, realizations, changes):
    sweep = tiny.sweep(realizations=realizations)
    if realizations and changes.get("chosen"):
        changes = {"chosen": tuple(at._replace(realization=2) for at in changes["chosen"])}
    with locked(tmp_path / "out.zarr"):
        prepare(tmp_path / "out.zarr", sweep)
        asked = replace(sweep, **changes)
        store = prepare(tmp_path / "out.zarr", asked)
    places = store.asked_places()
    assert set(store.points_at(np.nonzero(places))) == set(store.asked()) == set(points(asked))
    assert places.sum() == len(store.asked())
    every = store.places()
    assert [store.index(point) for point in every] == list(np.ndindex(*places.shape))
    assert list(store.status()) == every
    assert set(store.status().values()) <= {PENDING, DONE, FAILED}


def test_points_are_looked_for_where_files_are_and_in_no_other_file(copy):
    places = set(np.ndindex(*Store(copy).array("status").counts()))
    for name in ("c.99.0", "c.0", "c.0.0.0", "c.-1.0", "c.a.b", "x.0.0"):
        (copy / "status" / name).write_bytes(b"not a chunk")
    (copy / "status" / "c.0.0").unlink()
    store = Store(copy)
    assert sorted(store.places_of_chunks("status")) == sorted(places - {(0, 0)})
    flags, known = store.flags()
    assert (flags[0, 0], known[0, 0], known.sum()) == (PENDING, False, flags.size - 1)
    compact_store(copy)
    assert list(Store(copy).places_of_chunks("status")) == [(0, 0)]
