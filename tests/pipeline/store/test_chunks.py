"""Chunks that are written and read without Zarr's tasks."""

import json

import numpy as np
import pytest
import zarr
from pipeline.store.chunks import (
    ChunkedArray,
    _content_size,
    chunks_of,
    chunks_with,
    picked,
    values_at,
)
from pipeline.store.folder import as_json
from pipeline.store.layout import LEVEL
from pipeline.store.shape import _described
from pipeline.store.together import together
from pipeline.store.variables import BY_POINT, VARIABLES
from zarr.api.asynchronous import create_array
from zarr.codecs import ZstdCodec
from zarr.storage import MemoryStore

CASES = {
    "scalar": ("float64", (), (), 1.5),
    "flag": ("int8", (), (), 2),
    "checksum": ("uint64", (), (), 2**64 - 1),
    "text": ("str", (), (), "ΔT above 145 °C"),
    "no text": ("str", (), (), ""),
    "row": ("float64", (7,), (7,), np.linspace(0.0, 1.0, 7)),
    "nothing but fill": ("float64", (7,), (7,), np.full(7, np.nan)),
    "row of three chunks, the last cut": ("float64", (8,), (3,), np.arange(8.0)),
    "field in columns": ("float64", (5, 4), (5, 4), np.arange(20.0).reshape(4, 5).T),
    "field of big-endian numbers": ("float64", (2, 2), (2, 2), np.eye(2, dtype=">f8")),
}


def created(files, dtype, shape, chunks, separator=".", fill=None, block=(1, 1)):
    """An array with a chunk for each block of 2 × 3 points, of one each if not given."""
    creation = create_array(
        MemoryStore(files),
        name="variable",
        shape=(2, 3, *shape),
        chunks=(*block, *chunks),
        dtype=dtype,
        compressors=[ZstdCodec(level=LEVEL, checksum=True)],
        fill_value={"float64": np.nan, "str": ""}.get(dtype, 0) if fill is None else fill,
        chunk_key_encoding={"name": "default", "separator": separator},
    )
    with zarr.config.set({"array.write_empty_chunks": True}):
        (array,) = together([creation])
    return array


def own(array):
    """The same array, as its metadata describe it."""
    return ChunkedArray.of(array.path, array.metadata.to_dict())


def content_of(files):
    return lambda key: files[key].to_bytes() if key in files else None


@pytest.mark.parametrize("separator", [".", "/"])
@pytest.mark.parametrize(("dtype", "shape", "chunks", "values"), CASES.values(), ids=CASES.keys())
def test_chunks_are_those_that_zarr_writes(dtype, shape, chunks, values, separator):
    files, index = {}, (1, 2)
    array = created(files, dtype, shape, chunks, separator)
    together([array.setitem(index, values)])
    written = {key: file.to_bytes() for key, file in files.items() if "zarr.json" not in key}
    assert written
    assert dict(chunks_of(own(array), index, values)) == written


@pytest.mark.parametrize("index", [(1, 2), (0, 0), (1,), ()], ids=str)
@pytest.mark.parametrize(("dtype", "shape", "chunks", "values"), CASES.values(), ids=CASES.keys())
def test_values_are_those_that_zarr_reads(dtype, shape, chunks, values, index):
    """Also where there is no chunk."""
    files = {}
    array = created(files, dtype, shape, chunks)
    together([array.setitem((1, 2), values), array.setitem((0, 1), values)])
    found = values_at(own(array), index, content_of(files))
    (expected,) = together([array.getitem((*index, ...))])
    assert np.shape(found) == np.shape(expected)
    np.testing.assert_array_equal(found, np.asarray(expected, np.asarray(found).dtype))


@pytest.mark.parametrize("rows", [[0], [1, 0], [0, 1]])
@pytest.mark.parametrize("entries", [[5], [0, 2], [0, 1, 3, 6, 7], [7, 2, 1], [4, 4], range(8)])
def test_any_entries_are_picked_in_the_order_asked_for(rows, entries):
    files = {}
    array = created(files, "float64", (8,), (3,))
    values = np.arange(48.0).reshape(2, 3, 8)
    together([array.setitem((), values)])
    picks = (rows, [2, 0], list(entries))
    found = picked(
        own(array),
        picks,
        lambda keys: map(content_of(files), keys),
        lambda _: True,
        lambda key, place: pytest.fail(f"{key} is there"),
    )
    np.testing.assert_array_equal(found, values[np.ix_(*picks)])


@pytest.mark.parametrize(("dtype", "fill"), [("int8", 3), ("float64", 1.5), ("uint64", 7)])
def test_where_there_is_no_chunk_there_is_what_fills_it(dtype, fill):
    found = values_at(own(created({}, dtype, (4,), (3,), fill=fill)), (), lambda _: None)
    assert found.dtype == dtype
    np.testing.assert_array_equal(found, np.full((2, 3, 4), fill))


@pytest.mark.parametrize(("dtype", "values"), [("float64", 1.5), ("str", "worn through")])
def test_damaged_chunks_are_errors(dtype, values):
    array = created({}, dtype, (), ())
    ((_, chunk),) = chunks_of(own(array), (0, 0), values)
    for damaged in (b"", b"no chunk", chunk[:-1], chunk[:9] + b"?" + chunk[10:]):
        with pytest.raises((RuntimeError, ValueError)):
            values_at(own(array), (0, 0), lambda _, damaged=damaged: damaged)


def test_a_chunk_of_another_size_is_an_error():
    array = created({}, "float64", (3,), (3,))
    ((_, chunk),) = chunks_of(own(created({}, "float64", (4,), (4,))), (0, 0), np.arange(4.0))
    with pytest.raises(ValueError, match="bytes instead of 3 numbers"):
        values_at(own(array), (0, 0), lambda _: chunk)


@pytest.mark.parametrize("others", ["kept", "not there"])
def test_entries_are_put_into_the_chunks_that_they_share(others):
    files, new = {}, {(1, 1): -np.arange(8.0), (1, 0): np.full(8, 5.0)}
    array = created(files, "float64", (8,), (3,), block=(2, 2))
    values = np.arange(48.0).reshape(2, 3, 8)
    together([array.setitem((), values)])
    mine, content = own(array), content_of(files)

    def there(key, place):
        assert key == mine.key(place)
        return mine.decoded(content(key)) if others == "kept" else None

    written = dict(chunks_with(mine, (0, 0), new, there))
    assert set(written) == {mine.key((0, 0, i)) for i in range(3)}
    found = picked(
        mine,
        [np.arange(2), np.arange(3), np.arange(8)],
        lambda keys: (written.get(key, content(key)) for key in keys),
        lambda _: True,
        lambda *_: None,
    )
    expected = values.copy()
    if others != "kept":
        expected[:2, :2] = np.nan
    for index, each in new.items():
        expected[index] = each
    np.testing.assert_array_equal(found, expected)


MAGIC = b"\x28\xb5\x2f\xfd"


@pytest.mark.parametrize(
    ("header", "size"),
    [
        (b"\x20\x07", 7),
        (b"\x21\xff\x07", 7),  # after a dictionary's number, of 1, 2 or 4 bytes
        (b"\x22\xff\xff\x07", 7),
        (b"\x23\xff\xff\xff\xff\x07", 7),
        (b"\x60\x05\x01", 256 + 261),
        (b"\x40\xff\x05\x01", 256 + 261),  # after the size of a window
        (b"\xa0\x01\x02\x03\x04", 0x04030201),
        (b"\xe0\x01\x02\x03\x04\x05\x06\x07\x08", 0x0807060504030201),
    ],
)
def test_a_frame_says_how_large_its_content_is(header, size):
    assert _content_size(MAGIC + header + b"\xff" * 8 * (len(header) != 2)) == size


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (b"", "not compressed"),
        (MAGIC + b"\x20", "not compressed"),
        (b"\x28\xb5\x2f\xfc\x20\x07", "not compressed"),
        (b"\x28\xb5\x2f\xfe\x20\x07", "not compressed"),
        (MAGIC + b"\x00\x07", "does not say how large"),
    ],
)
def test_what_is_no_frame_or_does_not_say_its_size_is_an_error(frame, message):
    with pytest.raises(ValueError, match=message):
        _content_size(frame)


@pytest.mark.parametrize("name", VARIABLES)
def test_metadata_are_those_that_zarr_writes(name):
    files, variable = {}, VARIABLES[name]
    shape = list(range(3, 3 + len(variable.dims)))
    own = _described(name, variable, shape, [3, 2])
    creation = create_array(
        MemoryStore(files),
        shape=shape,
        dtype=variable.dtype,
        chunks=tuple(own["chunk_grid"]["configuration"]["chunk_shape"]),
        compressors=[ZstdCodec(level=LEVEL, checksum=True)],
        fill_value={"float64": np.nan, "str": ""}.get(variable.dtype, 0),
        chunk_key_encoding={"name": "default", "separator": BY_POINT},
        dimension_names=variable.dims,
        attributes=own["attributes"],
    )
    together([creation])
    assert json.loads(files["zarr.json"].to_bytes()) == json.loads(as_json(own))
