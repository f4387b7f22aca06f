"""Parts of a store: chunks, names, messages, places and checksums, at their bounds."""

import errno
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from numcodecs.zstd import Zstd

import pipeline
import tribo
from pipeline.store import create, files, root
from pipeline.store.checksum import checksum, packed
from pipeline.store.create import writing
from pipeline.store.inputs import inputs_variable, joined_arrays, split_arrays
from pipeline.store.layout import (
    block_of,
    blocks,
    bytes_of_a_point,
    chunk_key,
    documents,
    field_key,
    grown_axes,
    made_coordinates,
    slices_of,
    spread_ids,
)
from pipeline.store.place import (
    ROOT,
    Bucket,
    DamagedError,
    Folder,
    StoreError,
    decodes,
    is_lack_of_memory,
    place_of,
    reaches,
    require_writable,
    writes,
)
from pipeline.store.progress import FailedPoint, Summary, summarized
from pipeline.store.schema import DONE, FAILED, is_coordinate, is_of_points, path_of, variables_of
from pipeline.store.verify import verify_store
from pipeline.store.versions import provenance
from pipeline.store.write import Writer, stored
from pipeline.sweep.identity import Simulated
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.stages import Progress
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.stores import commit, fail, make, opened, record

SWEEP, POINT = tiny.full(), Point(250.0, 1.0)


def sizes(**values):
    return dict(values)


# Chunks


@pytest.mark.parametrize(
    ("lengths", "bytes_of_point", "block"),
    [
        (sizes(load=3000, velocity=3), 1, sizes(load=1024, velocity=1)),
        (sizes(load=3000, velocity=3), 2**22, sizes(load=64, velocity=1)),
        (sizes(load=3, velocity=2), 1, sizes(load=3, velocity=16)),  # a search adds others
        (sizes(load=3, velocity=40), 1, sizes(load=3, velocity=40)),
        (sizes(velocity=3), 1, sizes(velocity=16)),
        (sizes(velocity=900), 1, sizes(velocity=900)),
        (sizes(variant=5, sample=400, load=2, velocity=4), 2**14, sizes(variant=5, sample=1)),
        (sizes(sample=400, load=2, velocity=4), 2**14, sizes(sample=8, load=2, velocity=16)),
    ],
)
def test_a_chunk_has_all_loads_then_velocities_then_rows_within_its_bytes(
    lengths, bytes_of_point, block
):
    found = block_of(lengths, bytes_of_point)
    assert list(found) == list(lengths)
    assert found == found | block
    assert np.prod([*found.values()]) <= 1024


def test_a_point_counts_by_its_largest_variable_of_steps():
    axes = {"step": [0] * 7, "cooler_share": [0.0] * 5, "load": [1.0] * 9, "velocity": [1.0] * 9}
    assert bytes_of_a_point(variables_of(SWEEP), axes) == 8 * 7 * 5


def test_chunks_are_those_that_hold_a_point_of_a_mask():
    mask = np.zeros((5, 4), bool)
    mask[4, 3] = mask[0, 0] = True
    found = dict(blocks(mask, (2, 3)))
    assert found == {
        (0, 0): (slice(0, 2), slice(0, 3)),
        (2, 1): (slice(4, 6), slice(3, 6)),
    }
    assert slices_of((2, 1), (2, 3)) == found[2, 1]


def test_files_of_chunks_are_called_by_their_numbers():
    assert chunk_key("time", (0, 2, 0)) == "time/c.0.2.0"
    assert field_key("rise", (3, 1)) == "fields/rise/c.3.1.0.0"


def test_axes_grow_in_order_and_steps_backwards():
    axes = grown_axes({}, SWEEP, SWEEP)
    assert axes["load"] == [150.0, 250.0, 600.0]
    assert axes["velocity"] == [0.5, 1.0, 1.5]
    assert axes["step"] == list(range(1 - len(axes["step"]), 1))
    assert axes["x"] == SWEEP.scene.grid.coordinates(0).tolist()
    assert axes["y"] == SWEEP.scene.grid.coordinates(1).tolist()
    assert axes["cooler_share"] == list(tribo.QUANTILES)
    more = grown_axes(
        {**axes, "step": list(range(-99, 1))},
        SWEEP,
        changed(SWEEP, loads=(150.0, 200.0), velocities=(0.1, 0.5)),
    )
    assert more["load"] == [150.0, 200.0, 250.0, 600.0]
    assert more["velocity"] == [0.1, 0.5, 1.0, 1.5]
    assert more["step"] == list(range(-99, 1))


def test_a_distance_is_the_speed_times_the_time_and_ends_at_the_load():
    axes = grown_axes({}, SWEEP, SWEEP)
    made = made_coordinates(SWEEP, axes | {"velocity": [-0.5, 1.0, 1.5]})
    time, load = made["time"], made["normal_load"]
    assert load[:, -1].tolist() == [150.0, 250.0, 600.0]
    rate = SWEEP.scene.loading.rate
    known = np.isfinite(time)
    np.testing.assert_allclose(load[known], rate * time[known])
    assert (np.isnan(time) == np.isnan(load)).all()
    assert (known[2] >= known[1]).all()  # the highest load has the most steps
    assert known[2].sum() > known[0].sum()
    assert (known[0] == np.sort(known[0])).all()  # those that it lacks lie before its first
    distances = made["sliding_distance"]
    assert distances.shape == (3, 3, len(axes["step"]))
    for number, speed in enumerate((0.5, 1.0, 1.5)):
        np.testing.assert_allclose(distances[:, number], speed * time)


def test_documents_of_arrays_are_written_before_any_root():
    axes = grown_axes({}, SWEEP, SWEEP)
    wanted = variables_of(SWEEP)
    axes = {name: values for name, values in axes.items() if name in wanted}
    values = axes | made_coordinates(SWEEP, axes) | {"scene_id": spread_ids(SWEEP, axes, [7])}
    contents, metadata = documents(wanted, values, {"load": 3, "velocity": 16})
    assert ROOT not in contents
    assert {f"{path_of(name)}/{ROOT}" for name in wanted} <= {*contents}
    assert metadata.keys() == wanted.keys()

    def chunk(name):
        return metadata[name]["chunk_grid"]["configuration"]["chunk_shape"]

    steps, shares = len(axes["step"]), len(axes["cooler_share"])
    assert chunk("rise_quantile") == [3, 16, steps, shares]
    assert chunk("rise") == [1, 1, 32, 16]
    assert chunk("load") == [4096]
    assert chunk("x") == [32]
    assert chunk("time") == [3, steps]
    about = metadata["mean_rise"]
    assert about["attributes"]["units"] == "K"
    assert about["dimension_names"] == ["load", "velocity", "step"]
    assert about["fill_value"] == "NaN"
    assert metadata["status"]["fill_value"] == 0
    assert metadata["message"]["fill_value"] == ""
    assert "units" not in metadata["status"]["attributes"]


def test_what_tells_points_apart_is_told_from_what_belongs_to_each():
    assert [is_of_points(dim) for dim in ("load", "velocity", "sample")] == [True] * 3
    assert not any(map(is_of_points, ("step", "cooler_share", "bulk_ratio", "x", "y", "input")))
    for name in ("load", "time", "sliding_distance", "inputs", "pin.radius"):
        assert is_coordinate(name)
    for name in ("status", "mean_rise", "bulk_response", "pressure", "bulk_rise_quantile"):
        assert not is_coordinate(name)


# Arrays of a scene


def test_arrays_of_a_scene_lie_one_after_the_other_and_are_told_apart_by_their_digests():
    arrays = {"a1": np.arange(6.0).reshape(2, 3), "b2": np.array([7.0]), "c3": np.ones(4)}
    variable = inputs_variable(arrays)
    assert variable.attributes == {"digests": "a1 b2 c3", "sizes": "6 1 4"}
    values = joined_arrays(arrays)
    assert values.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 1.0, 1.0, 1.0, 1.0]
    split = split_arrays(values, variable.attributes)
    assert {name: of.tolist() for name, of in split.items()} == {
        "a1": [0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        "b2": [7.0],
        "c3": [1.0] * 4,
    }


# Checksums and records


def test_a_checksum_tells_scene_place_and_each_value():
    data = {"a": np.array([1.0, 2.0]), "b": b"encoded"}
    first = checksum("scene", Point(1.0, 2.0), data)
    assert first == checksum("scene", Point(1.0, 2.0), dict(reversed(data.items())))
    assert len(first) == 16  # 64 bits
    others = [
        checksum("other", Point(1.0, 2.0), data),
        checksum("scene", Point(2.0, 1.0), data),
        checksum("scene", Point(1.0, 2.0, (("sample", 1),)), data),
        checksum("scene", Point(1.0, 2.0), data | {"a": np.array([1.0, 2.5])}),
        checksum("scene", Point(1.0, 2.0), data | {"b": b"encodes"}),
        checksum("scene", Point(1.0, 2.0), {"a": data["a"], "c": data["b"]}),
        checksum("scene", Point(1.0, 2.0), data | {"message": "é"}),
    ]
    assert len({first, *others}) == 8
    apart = np.arange(8.0).reshape(2, 4).T  # not in one piece
    assert checksum("", POINT, {"a": apart}) == checksum("", POINT, {"a": apart.copy()})


def test_a_record_is_packed_once_with_fields_encoded_in_single_precision():
    simulated = Simulated(SWEEP)
    one = packed(record(POINT), simulated)
    assert packed(one, Simulated(tiny.full(increments=7))) is one
    rise = np.frombuffer(Zstd().decode(one.data["rise"]), np.float32)
    np.testing.assert_array_equal(rise, np.float32(record(POINT).data["rise"]).ravel())
    assert one.data["mean_rise"].dtype == float
    assert one.data["own_grid"].dtype == bool
    about = {"message": one.message, "warning_flags": np.int32(one.warning_flags)}
    assert one.checksum == checksum(simulated.at(POINT), POINT, one.data | about)


def test_a_failed_record_has_no_data_and_a_message_that_somebody_can_read():
    one = packed(PointRecord(POINT, None, "a\udcff" + 3000 * "b"), Simulated(SWEEP))
    assert one.data is None
    assert one.message == "a\\udcff" + 1998 * "b"
    assert one.checksum == checksum(
        Simulated(SWEEP).at(POINT),
        POINT,
        {"message": one.message, "warning_flags": np.int32(0)},
    )


# Places


def test_a_place_is_a_folder_or_an_address_without_its_last_slash(tmp_path, monkeypatch):
    assert place_of("s3://bucket/a/b.zarr/") == Bucket("s3://bucket/a/b.zarr")
    for wrong in ("a\0b", "a\ud800b"):
        with pytest.raises(StoreError, match=r"a store is a local folder, or an address such as"):
            place_of(wrong)
    with pytest.raises(StoreError, match=r"^/ cannot be a store; give a folder below it"):
        place_of("/")
    monkeypatch.chdir(tmp_path)
    assert place_of("a/../b.zarr") == Folder(tmp_path / "b.zarr")
    assert str(place_of("b.zarr")) == str(tmp_path / "b.zarr")
    assert str(Bucket("s3://bucket/a")) == "s3://bucket/a"


def test_keys_of_a_bucket_lie_below_its_address():
    assert Bucket("s3://bucket/a")._key("status/c.0") == "bucket/a/status/c.0"


def test_files_of_a_folder_are_made_once_and_told_with_their_folders(tmp_path):
    folder = Folder(tmp_path)
    assert folder.read("a") is None
    folder.put({"a": b"first"})
    assert folder.read("a") == b"first"
    assert folder.read("a/b") is None  # below a file
    folder.put({"b/c": b"1", ROOT: b"22"})
    assert folder.keys() == {"a", "b/c", ROOT}
    assert Folder(tmp_path / "none").keys() == set()


def test_a_file_above_a_store_is_the_reason_why_it_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    path = tmp_path / "file" / "a.zarr"
    said = rf"^{path} cannot be written: {tmp_path}/file is a file, not a folder$"
    with pytest.raises(StoreError, match=said):
        require_writable(path)
    with (
        pytest.raises(StoreError, match=r"^s3://b/c cannot be written: no room; later$"),
        writes(Bucket("s3://b/c"), "; later"),
    ):
        raise OSError(errno.ENOSPC, "no room")
    require_writable(tmp_path / "new" / "folder" / "a.zarr")
    assert (tmp_path / "new" / "folder").is_dir()
    assert not (tmp_path / "new" / "folder" / "a.zarr").exists()
    require_writable("s3://bucket/a.zarr")


def test_what_cannot_be_read_is_named_by_its_file_or_else_by_its_place():
    with (
        pytest.raises(StoreError, match=r"^/a/b cannot be read: gone; see to its permissions"),
        reaches(Folder(Path("/a"))),
    ):
        raise OSError(errno.EIO, "gone", "/a/b")
    with (
        pytest.raises(StoreError, match=r"^/a cannot be read: gone; see to its permissions"),
        reaches(Folder(Path("/a"))),
    ):
        raise OSError("gone")
    with (
        pytest.raises(DamagedError, match=r"^/a: rise cannot be read; irg verify"),
        decodes(Folder(Path("/a")), "rise"),
    ):
        raise ValueError("no zstd")


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        OSError(errno.ENOMEM, ""),
        OSError(errno.EAGAIN, ""),
        RuntimeError("can't start new thread"),
        ValueError("failed to map segment from shared object"),
        RuntimeError("Cannot allocate memory"),
    ],
)
def test_a_lack_of_memory_is_no_fault_of_the_data(error):
    assert is_lack_of_memory(error)
    for context in (reaches(Folder(Path("/a"))), decodes(Folder(Path("/a")), "rise")):
        with pytest.raises(type(error)) as caught, context:
            raise error
        assert caught.value is error


def test_other_errors_are_no_lack_of_memory():
    for error in (OSError(errno.EIO, "start new thread"), ValueError("no zstd"), RuntimeError()):
        assert not is_lack_of_memory(error)


# Roots and sizes


def test_a_store_has_as_many_points_as_its_most_and_no_more(path, monkeypatch):
    for module in (root, create):
        monkeypatch.setattr(module, "MOST_POINTS", 400)
    loads, velocities = (150.0, 250.0, 600.0, 700.0), tuple(np.linspace(0.1, 10.0, 100).tolist())
    make(path, tiny.sweep(loads=loads, velocities=velocities))
    assert opened(path).flags.size == 400
    with pytest.raises(StoreError, match=r"would have 404 points; a store has at most 4e\+02"):
        make(path, tiny.sweep(loads=loads, velocities=(11.0,)))
    monkeypatch.setattr(root, "MOST_POINTS", 399)
    with pytest.raises(StoreError, match=r"it has 400 points, and a store at most 4e\+02"):
        opened(path)


@dataclass(frozen=True)
class Memory(Bucket):
    """A bucket that is a dictionary."""

    objects: dict = field(default_factory=dict)

    def read(self, key):
        return self.objects.get(key)

    def put(self, contents):
        self.objects.update(contents)

    def keys(self):
        return {*self.objects}


def test_a_store_has_room_for_the_steps_of_twice_the_reference_load():
    found = create._grown_root(Memory("s3://bucket/a"), None, SWEEP)
    assert found.axes["step"] == list(range(-2 * 6, 1))
    few = create._grown_root(Memory("s3://bucket/b"), None, tiny.full(increments=30))
    assert few.axes["step"] == list(range(-2 * 30, 1))
    ends = create._grown_root(Memory("s3://bucket/c"), None, tiny.full(steps="end"))
    assert ends.axes["step"] == [0]  # no course, and so no room for one


def test_a_bucket_takes_what_lies_behind_its_values_and_not_between_them():
    bucket = Memory("s3://bucket/a")
    before = create._grown_root(bucket, None, SWEEP)
    assert create._grown_root(bucket, before, SWEEP) is before
    after = create._grown_root(bucket, before, tiny.full(velocities=(2.0,)))
    assert after.axes["velocity"] == [0.5, 1.0, 1.5, 2.0]
    assert after.facts.points_per_chunk == before.facts.points_per_chunk
    kept = dict(bucket.objects)
    with pytest.raises(StoreError, match="velocity would not grow at its upper end; write a new"):
        create._grown_root(bucket, after, tiny.full(velocities=(0.75,)))
    assert bucket.objects == kept


def test_progress_of_a_verification_counts_points_that_are_done(path):
    commit(path, SWEEP, [POINT, Point(600.0, 1.0)])
    told = []
    verify_store(path, progress=told.append)
    assert told == [Progress(done=2, total=2)]


# What was computed, by whom, and how far


def test_versions_are_told_in_the_order_in_which_they_came():
    first, later = {"tribo": "1.0", "numpy": "2.1", "zarr": "3.0"}, {"tribo": "1.1", "numpy": "2.2"}
    said = provenance(first, {"2026-01-02": later}, {"2026-01-03": {"tribo": "9", "numpy": "2.3"}})
    assert said["source"] == "simulated by irg-transition 1.0"
    assert said["history"].splitlines() == [
        "computed by irg-transition 1.0 with numpy 2.1, zarr 3.0",
        "2026-01-02: gone on with by irg-transition 1.1 with numpy 2.2",
        "2026-01-03: some points computed by workers with tribo 9, numpy 2.3",
    ]


def test_versions_are_noted_when_they_are_not_the_last_ones(monkeypatch):
    monkeypatch.setattr(root, "package_versions", lambda: {"numpy": "2"})
    facts = root.Facts(axes={}, points_per_chunk={}, versions={"numpy": "2"})
    assert facts.note_versions() is facts
    monkeypatch.setattr(root, "package_versions", lambda: {"numpy": "3"})
    later = facts.note_versions()
    assert later.versions == {"numpy": "2"}
    assert [*later.later_versions.values()] == [{"numpy": "3"}]
    assert later.note_versions() is later


def test_versions_of_workers_are_noted_once(path):
    commit(path, SWEEP, [POINT])
    with writing(path, SWEEP) as store:
        for _ in range(2):
            store.note_worker({"numpy": "1.0"})
    assert [*opened(path).root.facts.worker_versions.values()] == [{"numpy": "1.0"}]


def test_states_of_points_are_counted_by_what_the_scene_asks_for(path):
    commit(path, SWEEP, [POINT, Point(600.0, 1.0)])
    fail(path, SWEEP, Point(150.0, 0.5), "it diverged")
    store = make(path, tiny.full(loads=(150.0, 250.0), velocities=(0.5, 1.0)))
    found = summarized(store)
    assert (found.name, found.title) == ("tiny", "A tiny sweep")
    assert (found.total, found.done, found.pending, found.earlier) == (4, 1, 2, 1)
    assert [str(point) for point in found.failed] == ["150 N, 0.5 m/s: it diverged"]
    assert isinstance(found, Summary)
    assert store.pending() == [Point(150.0, 1.0), Point(250.0, 0.5)]
    assert found.failed == (FailedPoint(150.0, 0.5, "it diverged"),)
    store = opened(path)
    assert store.flags[store.index(Point(150.0, 0.5))] == FAILED
    assert store.flags[store.index(POINT)] == DONE


def test_a_failed_point_is_told_by_its_place_in_words_or_else_its_values():
    assert str(FailedPoint(150.0, 0.5, "why")) == "150 N, 0.5 m/s: why"
    assert str(FailedPoint(150.0, 0.5, "why", (), "here")) == "here: why"


# Reading and writing points


def test_places_of_points_and_of_their_chunks_go_both_ways(copy):
    store = opened(copy)
    assert store.index(Point(600.0, 1.0)) == (2, 1)
    assert store.points_at((np.array([2, 0]), np.array([1, 2]))) == [
        Point(600.0, 1.0),
        Point(150.0, 1.5),
    ]
    assert store.block == (3, 16)
    assert store.chunk_of((4, 17)) == (1, 1)
    assert store.within((4, 17)) == (1, 1)
    assert [*store.chunk_keys("mean_rise", (0, 0))] == ["mean_rise/c.0.0.0"]
    assert [*store.chunk_keys("rise", (2, 1))] == ["fields/rise/c.2.1.0.0"]
    mask = np.zeros((3, 3), bool)
    assert not store.lacks("rise", mask, set())
    mask[2, 1] = True
    assert store.lacks("rise", mask, {"fields/rise/c.2.2.0.0"})
    assert not store.lacks("rise", mask, {"fields/rise/c.2.1.0.0"})


def test_steps_are_read_with_their_time_load_and_distance_in_one_shape(copy):
    store = opened(copy)
    steps = store.read_steps()
    assert len({values.shape[:3] for values in steps.values()}) == 1
    number = store.index(POINT)
    assert steps["normal_load"][number][-1] == 250.0
    np.testing.assert_allclose(
        steps["sliding_distance"][number], 1.0 * steps["time"][number], equal_nan=True
    )
    known = record(POINT).data["mean_rise"]
    np.testing.assert_array_equal(steps["mean_rise"][number][-len(known) :], known)


def test_what_a_command_caches_is_kept_by_a_run_alone(copy):
    keeper = pipeline.open_sweep(copy)["status"].encoding["keeper"]
    keeper.keep("a", b"content")
    assert keeper.kept("a") is None
    keeper.may_keep = True
    keeper.keep("a", b"content")
    assert keeper.kept("a") == b"content"
    assert verify_store(copy).is_clean


def test_a_search_writes_to_a_folder_that_is_deleted_unless_it_has_one(tmp_path):
    with stored(tmp_path / "a.zarr") as given:
        assert given == tmp_path / "a.zarr"
    with stored(None) as made:
        assert made.parent.is_dir()
        assert made.name == "points.zarr"
    assert not made.parent.exists()


def test_commits_to_a_bucket_are_ten_seconds_apart():
    class Quick:
        place = Bucket("s3://bucket/a")

        def commit(self, records):
            pass

    for there, pause in ((Bucket("s3://bucket/a"), 10.0), (Folder(Path("/a")), 1.0)):
        Quick.place = there
        with Writer(Quick()) as writer:
            writer.add(["one"])
            writer.flush()
            assert writer.written() == ["one"]
            assert writer._pause == pause


def test_a_run_that_lost_its_lock_is_told_so_and_writes_nothing(copy):
    store = opened(copy)
    store.lock = lambda: False
    before = (copy / "status" / "c.0.0").read_bytes()
    with pytest.raises(StoreError, match=r"its lock \(status/lock\) was deleted or replaced"):
        store.forget([POINT])
    assert (copy / "status" / "c.0.0").read_bytes() == before
    store.lock = lambda: True
    store.require_lock()


# Files


def test_a_file_is_told_from_a_folder_a_link_and_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "link").symlink_to(tmp_path / "none")
    (tmp_path / "good").symlink_to(tmp_path / "file")
    (tmp_path / "folder").mkdir()
    (tmp_path / "aside").symlink_to(tmp_path)
    assert files.is_there(tmp_path, "file")
    assert files.is_there(tmp_path / "aside", "file")
    assert not files.is_there(tmp_path, "none")
    assert not files.is_there(tmp_path, "file/below")
    for key, link in {"link": "link", "good": "good", "aside/file": "aside"}.items():
        with pytest.raises(OSError, match="is a link, and a store has none") as caught:
            files.is_there(tmp_path, key)
        assert caught.value.filename == f"{tmp_path}/{link}"
    with pytest.raises(OSError, match="it is not a file"):
        files.is_there(tmp_path, "folder")
    for outside in ("../file", "folder/../file", f"{tmp_path}/file", "", "folder//file"):
        with pytest.raises(OSError, match="names no file within a store"):
            files.is_there(tmp_path, outside)


def test_files_are_replaced_whole_with_their_folders_and_not_through_links(tmp_path):
    files.replace_files(tmp_path, {"a/b/c": b"1", "d": b"2"})
    files.replace_files(tmp_path, {"d": b"3"})
    assert (tmp_path / "a" / "b" / "c").read_bytes() == b"1"
    assert (tmp_path / "d").read_bytes() == b"3"
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a", "d"]
    (tmp_path / "link").symlink_to(tmp_path / "a")
    with pytest.raises(OSError, match=f"it is a link.*{tmp_path}/link"):
        files.replace_file(tmp_path, "link/e", b"4")
    assert not (tmp_path / "a" / "e").exists()


@pytest.mark.parametrize(("number", "passes"), [(errno.EINVAL, True), (errno.EIO, False)])
def test_a_folder_that_cannot_be_synced_is_no_fault_and_a_broken_disk_is(
    tmp_path, monkeypatch, number, passes
):
    def refused(_):
        raise OSError(number, "refused")

    monkeypatch.setattr(files.os, "fsync", refused)
    if passes:
        files.sync(tmp_path)
    else:
        with pytest.raises(OSError, match="refused"):
            files.sync(tmp_path)
