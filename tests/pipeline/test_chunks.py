"""Chunks that are written without Zarr's tasks."""

import numpy as np
import pytest
import zarr
from zarr.api.asynchronous import create_array
from zarr.storage import MemoryStore

from pipeline.chunks import COMPRESSOR, chunks_of, numbers_in
from pipeline.together import together

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


@pytest.mark.parametrize("separator", [".", "/"])
@pytest.mark.parametrize(("dtype", "shape", "chunks", "values"), CASES.values(), ids=CASES.keys())
def test_chunks_are_those_that_zarr_writes(dtype, shape, chunks, values, separator):
    files, index = {}, (1, 2)
    with zarr.config.set({"array.write_empty_chunks": True}):
        creation = create_array(
            MemoryStore(files),
            name="variable",
            shape=(2, 3, *shape),
            chunks=(1, 1, *chunks),
            dtype=dtype,
            compressors=[COMPRESSOR],
            fill_value={"float64": np.nan, "str": ""}.get(dtype, 0),
            chunk_key_encoding={"name": "default", "separator": separator},
        )
        (array,) = together([creation])
        together([array.setitem(index, values)])
    written = {key: file.to_bytes() for key, file in files.items() if "zarr.json" not in key}
    assert written
    assert dict(chunks_of(array, index, values)) == written


@pytest.mark.parametrize(("dtype", "fill"), [("int8", 0), ("float64", np.nan), ("uint64", 7)])
def test_numbers_are_those_that_zarr_reads(dtype, fill):
    files = {}
    creation = create_array(
        MemoryStore(files),
        name="variable",
        shape=(2, 3),
        chunks=(1, 1),
        dtype=dtype,
        compressors=[COMPRESSOR],
        fill_value=fill,
    )
    (array,) = together([creation])
    together([array.setitem((1, 2), 5)])
    found = numbers_in(array, lambda key: files[key].to_bytes() if key in files else None)
    assert found.dtype == dtype
    np.testing.assert_array_equal(found, together([array.getitem(slice(None))])[0])
    with pytest.raises(RuntimeError):
        numbers_in(array, lambda _: b"no chunk")
    with pytest.raises(ValueError, match="size"):
        numbers_in(array, lambda _: next(iter(dict(chunks_of(array, (0, 0), 5)).values())) * 2)
